// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/height_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace kestrel {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPeriod = 0.05;  // of a range finder, s

class HeightTrackerTest : public ::testing::Test {
 protected:
  /// Feeds readings for `duration` (s). Returns the largest difference between tracked and true
  /// height, m.
  double fly(double duration, const std::function<double(double)>& height,
             const std::function<double(double)>& floor) {
    double worst = 0.0;
    const auto steps = std::lround(duration / kPeriod);
    for (long i = 0; i < steps; ++i, time_ += kPeriod) {
      EXPECT_TRUE(tracker_.addRange({time_, height(time_) - floor(time_)}, nullptr));
      worst = std::max(worst, std::abs(*tracker_.height(time_) - height(time_)));
    }
    return worst;
  }

  static Projection seen(std::optional<double> mirror, std::optional<double> floor) {
    Projection projection;
    projection.mirror_height_m = mirror;
    projection.floor_height_m = floor;
    return projection;
  }

  double time_ = 1000.0;
  HeightTracker tracker_;
};

double level(double) { return 0.0; }
double hover(double) { return 1.5; }

TEST_F(HeightTrackerTest, HasNoHeightWithoutReadings) {
  EXPECT_FALSE(tracker_.height(time_));
  EXPECT_EQ(tracker_.source(time_), HeightSource::kNone);
}

TEST_F(HeightTrackerTest, ThePoseFilterIsPreferred) {
  EXPECT_TRUE(tracker_.addRange({time_, 1.03}, nullptr));
  EXPECT_TRUE(tracker_.addFiltered({time_, 1.0}));
  EXPECT_EQ(tracker_.height(time_), 1.0);
  EXPECT_EQ(tracker_.source(time_), HeightSource::kFilter);
  for (const double until = time_ + 2.0; time_ < until;) {  // no more readings of the filter
    EXPECT_TRUE(tracker_.addRange({time_ += kPeriod, 1.03}, nullptr));
  }
  EXPECT_EQ(tracker_.height(time_), 1.03);
  EXPECT_EQ(tracker_.source(time_), HeightSource::kRangeFinder);
  EXPECT_FALSE(tracker_.addFiltered({1000.01, kNotANumber}));
  EXPECT_FALSE(tracker_.addFiltered({1000.02, -0.1}));
  EXPECT_EQ(tracker_.counts().at("filter: used"), 1U);
  EXPECT_EQ(tracker_.counts().at("filter: not finite"), 1U);
}

TEST_F(HeightTrackerTest, FilteredHeightsHaveStepDetectionToo) {
  const auto below = [](double time) { return time < 1001.0 ? 0.0 : 0.7; };
  for (; time_ < 1002.0; time_ += 0.01) {
    EXPECT_TRUE(tracker_.addFiltered({time_, 1.5 - below(time_)}));
    EXPECT_NEAR(*tracker_.height(time_), 1.5, 1e-9) << time_;
  }
}

TEST_F(HeightTrackerTest, TheParameterIsUsedWithoutReadings) {
  HeightConfig config;
  config.fixed_m = 1.2;
  tracker_ = HeightTracker(config);
  EXPECT_EQ(tracker_.height(time_), 1.2);
  EXPECT_EQ(tracker_.source(time_), HeightSource::kParameter);
  tracker_.addRange({time_, 1.0}, nullptr);
  EXPECT_EQ(tracker_.height(time_), 1.0);
  EXPECT_EQ(tracker_.height(time_ + 1.1), 1.2) << "the reading is too old";
}

TEST_F(HeightTrackerTest, FollowsAClimb) {
  const auto climb = [](double t) { return 1.0 + 0.8 * std::sin(2.0 * (t - 1000.0)); };
  EXPECT_LT(fly(20.0, climb, level), 1e-12);
  EXPECT_EQ(tracker_.source(time_), HeightSource::kRangeFinder);
  EXPECT_EQ(tracker_.counts().at("used"), 400U);
}

TEST_F(HeightTrackerTest, InterpolatesBetweenReadings) {
  tracker_.addRange({10.0, 1.0}, nullptr);
  tracker_.addRange({10.1, 1.2}, nullptr);
  EXPECT_NEAR(*tracker_.height(10.025), 1.05, 1e-9);
  EXPECT_EQ(tracker_.height(9.5), 1.0);
  EXPECT_EQ(tracker_.height(11.0), 1.2);
  EXPECT_FALSE(tracker_.height(11.2));
  EXPECT_FALSE(tracker_.height(8.9));
  EXPECT_FALSE(tracker_.height(kNotANumber));
}

TEST_F(HeightTrackerTest, CorrectsTheRangeForTheTilt) {
  AttitudeBuffer attitude;
  const double tilt = 0.3;
  attitude.add(10.0, Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())), {});
  EXPECT_TRUE(tracker_.addRange({10.0, 2.0}, &attitude));
  EXPECT_NEAR(*tracker_.height(10.0), 2.0 * std::cos(tilt), 1e-12);
  attitude.add(10.1, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitY())), {});
  EXPECT_FALSE(tracker_.addRange({10.1, 2.0}, &attitude));
  EXPECT_EQ(tracker_.counts().at("tilted"), 1U);
  const AttitudeBuffer empty;
  EXPECT_TRUE(tracker_.addRange({10.2, 2.0}, &empty));
}

TEST_F(HeightTrackerTest, ATableIsNotTheFloor) {
  const auto table = [](double t) { return t > 1002.0 && t < 1004.0 ? 0.75 : 0.0; };
  const auto climb = [](double t) { return 1.5 + 0.3 * std::sin(t); };
  EXPECT_LT(fly(3.0, climb, table), 0.2)
      << "the motion during one reading becomes part of the step";
  EXPECT_NEAR(tracker_.stepBelow(), 0.75, 0.05);
  fly(3.0, climb, table);
  EXPECT_EQ(tracker_.stepBelow(), 0.0);
  EXPECT_LT(fly(3.0, climb, table), 1e-12);
}

TEST_F(HeightTrackerTest, ALongStepBecomesTheFloor) {
  const auto storey = [](double t) { return t > 1001.0 ? 0.6 : 0.0; };
  fly(2.0, hover, storey);
  EXPECT_NEAR(*tracker_.height(time_), 1.5, 1e-9);
  fly(4.0, hover, storey);
  EXPECT_NEAR(*tracker_.height(time_), 0.9, 1e-9);
}

TEST_F(HeightTrackerTest, IgnoresASpike) {
  const auto spike = [](double t) { return std::abs(t - 1001.0) < 0.01 ? 1.2 : 0.0; };
  EXPECT_LT(fly(2.0, hover, spike), 1e-9);
  EXPECT_EQ(tracker_.stepBelow(), 0.0);
}

TEST_F(HeightTrackerTest, HeightsFromTheLaserDistinguishTableAndFloor) {
  fly(1.0, hover, level);
  const auto table = [](double) { return 0.75; };
  for (int i = 0; i < 20; ++i) {  // ten seconds over a long table; the laser sees the floor
    fly(0.5, hover, table);
    tracker_.addProjection(time_ - kPeriod, seen({}, 1.45));
  }
  EXPECT_NEAR(*tracker_.height(time_), 1.5, 1e-9);
  tracker_.addProjection(time_, seen({}, 0.8));
  fly(0.1, hover, table);
  EXPECT_NEAR(*tracker_.height(time_), 0.75, 1e-9) << "the laser confirms that it is the floor";
}

TEST_F(HeightTrackerTest, UsesMirrorAndFloorWithoutARangeFinder) {
  tracker_.addProjection(10.0, seen({}, 1.1));
  EXPECT_EQ(tracker_.height(10.0), 1.1);
  EXPECT_EQ(tracker_.source(10.0), HeightSource::kFloor);
  tracker_.addProjection(10.1, seen(1.0, 1.1));
  EXPECT_EQ(tracker_.height(10.1), 1.0);
  EXPECT_EQ(tracker_.source(10.1), HeightSource::kMirror);
  EXPECT_EQ(tracker_.counts().at("mirror: used"), 1U);
  EXPECT_EQ(tracker_.counts().at("floor: used"), 2U);
  tracker_.addProjection(10.2, seen(kNotANumber, -kInfinity));
  EXPECT_EQ(tracker_.height(10.2), 1.0);
  EXPECT_EQ(tracker_.counts().at("mirror: not finite"), 1U);
  tracker_.addProjection(kNotANumber, seen(1.0, 1.0));
  EXPECT_FALSE(tracker_.height(12.0));
}

TEST_F(HeightTrackerTest, CountsAndRejectsBadReadings) {
  fly(1.0, hover, level);
  const std::pair<double, const char*> bad[] = {
      {kInfinity, "infinite"}, {-kInfinity, "too close"}, {kNotANumber, "not finite"},
      {0.0, "not positive"},   {-1.0, "not positive"},    {1e6, "too far"}};
  for (const auto& [value, reason] : bad) {
    const auto before = tracker_.counts();
    EXPECT_FALSE(tracker_.addRange({time_, value}, nullptr));
    const auto found = before.find(reason);
    EXPECT_EQ(tracker_.counts().at(reason), (found == before.end() ? 0U : found->second) + 1U);
    time_ += kPeriod;
  }
  EXPECT_FALSE(tracker_.addRange({kNotANumber, 1.0}, nullptr));
  EXPECT_FALSE(tracker_.addRange({time_ - 0.2, 1.0}, nullptr));
  EXPECT_EQ(tracker_.counts().at("bad stamp"), 1U);
  EXPECT_EQ(tracker_.counts().at("late"), 1U);
  EXPECT_NEAR(*tracker_.height(time_), 1.5, 1e-12);
  for (int i = 0; i < 40; ++i, time_ += kPeriod) tracker_.addRange({time_, kInfinity}, nullptr);
  EXPECT_FALSE(tracker_.height(time_)) << "all readings are older than a second";
  EXPECT_LT(fly(1.0, hover, level), 1e-12) << "must recover at once";
}

TEST_F(HeightTrackerTest, FollowsAClockThatWasSetBack) {
  fly(1.0, hover, level);
  time_ -= 100.0;
  for (int i = 0; i < 10; ++i, time_ += kPeriod) tracker_.addRange({time_, 0.7}, nullptr);
  EXPECT_NEAR(*tracker_.height(time_), 0.7, 1e-12);
  EXPECT_EQ(tracker_.counts().at("stamp jumps"), 2U);
  tracker_.restart();
  EXPECT_FALSE(tracker_.height(time_));
}

}  // namespace
}  // namespace kestrel
