// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "filter_flight.h"

namespace kestrel {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A flight of 25 s with bad input between 10 and 12 s.
class PoseFilterBadInput : public ::testing::Test {
 protected:
  static bool isBad(double time) { return time >= 10.0 && time < 12.0; }

  /// Feeds the flight and checks that every output is finite.
  void fly() {
    feeding_.until_s = 25.0;
    feeding_.output = [&](double time, const FilterOutput& output) {
      EXPECT_TRUE(output.map_T_base.matrix().allFinite());
      EXPECT_TRUE(output.odom_T_base.matrix().allFinite());
      EXPECT_TRUE(output.velocity.allFinite());
      EXPECT_TRUE(output.covariance.allFinite());
      EXPECT_GE(output.covariance.diagonal().minCoeff(), 0.0);
      worst_m_ = time > 3.0 ? std::max(worst_m_, errorsOf(flight_, output).position_m) : 0.0;
    };
    feed(flight_, feeding_, filter_);
  }

  FilterStatus status(double time = 25.0) const {
    return filter_.status(flight_.start_stamp + time);
  }

  void expectGood(double position_m = 0.05) {
    ASSERT_TRUE(filter_.output());
    const FilterErrors errors = errorsOf(flight_, *filter_.output());
    EXPECT_LT(errors.position_m, position_m);
    EXPECT_LT(errors.velocity, 0.1);
    EXPECT_LT(errors.tilt_rad, 0.01);
    EXPECT_EQ(status().health, FilterHealth::kOk) << status().message;
  }

  FilterFlight flight_;
  Feeding feeding_;
  PoseFilter filter_;
  double worst_m_ = 0.0;
};

}  // namespace kestrel
