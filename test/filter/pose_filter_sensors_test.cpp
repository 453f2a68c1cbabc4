// SPDX-License-Identifier: BSD-3-Clause
// Tests of the sensors of the pose filter; see pose_filter_test.cpp for the filter as a whole.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "filter_flight.h"
#include "kestrel_slam/filter/pose_filter.h"

namespace kestrel {
namespace {

TEST(PoseFilter, UsesThePositionOfTheImu) {
  FilterFlight flight;
  flight.base_T_imu = Eigen::Translation3d(0.4, -0.3, 0.2) *
                      Eigen::AngleAxisd(2.0, Eigen::Vector3d(1.0, 2.0, -1.0).normalized());
  const auto worstVelocity = [&](const Eigen::Isometry3d& mounting) {
    FilterFlight assumed = flight;
    PoseFilter filter;
    double worst = 0.0;
    Feeding feeding;
    feeding.imu = [&](double time, ImuSample& sample) {
      const double stamp = sample.stamp;
      sample = flight.imu(time);
      sample.stamp = stamp;
      return true;
    };
    feeding.output = [&](double time, const FilterOutput& output) {
      if (time > 5.0) worst = std::max(worst, errorsOf(flight, output).velocity);
    };
    assumed.base_T_imu = mounting;
    feed(assumed, feeding, filter);
    return worst;
  };
  Eigen::Isometry3d without_lever = flight.base_T_imu;
  without_lever.translation().setZero();
  const double right = worstVelocity(flight.base_T_imu), wrong = worstVelocity(without_lever);
  EXPECT_LT(right, 0.05);
  EXPECT_GT(wrong, 2.0 * right);
}

TEST(PoseFilter, KeepsTheHeightOverATable) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  constexpr double kTable = 0.7;
  feeding.range = [](double time, HeightSample& range) {
    const bool over_table = (time > 8.0 && time < 11.0) || time > 17.0;
    return range.height_m -= over_table ? kTable : 0.0, true;
  };
  double worst = 0.0;
  feeding.output = [&](double time, const FilterOutput& output) {
    if (time < 3.0) return;
    const double truth = flight.at(time).position.z();
    worst = std::max(worst, std::abs(output.map_T_base.translation().z() - truth));
    if (time > 9.0 && time < 11.0) {
      EXPECT_NEAR(output.ground_m, kTable, 0.05) << time;
    } else if (time > 12.0 && time < 17.0) {
      EXPECT_NEAR(output.ground_m, 0.0, 0.02) << time;  // over the floor again
    }
  };
  feed(flight, feeding, filter);
  EXPECT_LT(worst, 0.04);
  EXPECT_EQ(statusAtEnd(filter, flight, 20.0).of(FilterSensor::kRange).rejected.at("step below"),
            3U);
}

// At an edge, the first reading lies between both levels.
TEST(PoseFilter, KeepsTheHeightOverAStepThatComesInTwoParts) {
  for (const auto& [level, part] : {std::pair(0.4, 0.2), std::pair(1.25, 1.08)}) {
    const FilterFlight flight;
    PoseFilter filter;
    Feeding feeding;
    bool was_over = false;
    feeding.range = [&, level = level, part = part](double time, HeightSample& range) {
      const bool is_over = time > 8.0 && time < 11.0;
      range.height_m -= is_over != was_over ? part : is_over ? level : 0.0;
      was_over = is_over;
      return true;
    };
    double worst = 0.0;
    feeding.output = [&](double time, const FilterOutput& output) {
      const double truth = flight.at(time).position.z();
      if (time > 3.0)
        worst = std::max(worst, std::abs(output.map_T_base.translation().z() - truth));
    };
    feed(flight, feeding, filter);
    EXPECT_LT(worst, 0.06) << level;
  }
}

TEST(PoseFilter, ABarometerStabilizesTheHeight) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 40.0;
  Random random(3);
  feeding.range = [](double time, HeightSample&) { return time < 10.0; };
  feeding.imu = [&](double time, ImuSample& sample) {
    HeightSample barometer{sample.stamp, 431.0 + flight.position(time).z()};
    barometer.height_m += 0.1 * random.gaussian();
    if (std::lround(time * 100.0) % 10 == 0) filter.addBarometer(barometer);
    return true;
  };
  feed(flight, feeding, filter);
  const double error = filter.output()->map_T_base.translation().z() - flight.position(39.99).z();
  EXPECT_LT(std::abs(error), 0.3);
  EXPECT_LT(std::abs(error), 3.0 * std::sqrt(filter.output()->covariance(5, 5)));
}

TEST(PoseFilter, UsesPositionsAndYaws) {
  const FilterFlight flight;
  PoseFilter filter;
  Feeding feeding;
  feeding.until_s = 40.0;
  feeding.per_pose = feeding.per_range = 0;
  Random random(5);
  int i = 0;
  feeding.imu = [&](double time, ImuSample& sample) {
    if (++i % 20 == 0) {
      PositionMeasurement fix{sample.stamp, flight.position(time),
                              0.25 * Eigen::Matrix3d::Identity()};
      for (double& axis : fix.position) axis += 0.5 * random.gaussian();
      filter.addPosition(fix);
    }
    if (i % 10 == 0) {
      filter.addYaw({sample.stamp, flight.at(time).yaw() + 0.05 * random.gaussian(), 0.1});
    }
    return true;
  };
  feed(flight, feeding, filter);
  const FilterErrors errors = errorsOf(flight, *filter.output());
  EXPECT_LT(errors.position_m, 0.6);
  EXPECT_LT(errors.velocity, 0.3);
  EXPECT_LT(errors.yaw_rad, 0.1);
  const FilterStatus status = statusAtEnd(filter, flight, 40.0);
  EXPECT_EQ(status.health, FilterHealth::kOk);
  EXPECT_GT(status.of(FilterSensor::kYaw).accepted, 300U);
}

}  // namespace
}  // namespace kestrel
