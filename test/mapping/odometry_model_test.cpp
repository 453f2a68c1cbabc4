// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

/// A drive in steps of 0.2 m with some turns; `measure` gives the odometry of a true step.
template <typename Measure>
OdometryModel modelOf(int steps, Measure measure) {
  OdometryModel model;
  for (int i = 0; i < steps; ++i) {
    const Pose2 step(0.2, 0.0, 0.1 * std::sin(0.1 * i));
    model.learn(measure(step, i), step);
  }
  return model;
}

const Pose2 kMeter(1.0, 0.0, 0.0);

TEST(OdometryModel, AssumesThirtyPercentBeforeItLearns) {
  const OdometryModel model;
  EXPECT_EQ(model.corrected(kMeter), kMeter);
  EXPECT_NEAR(model.errorOf(kMeter).position_m, 0.3, 0.005);
  EXPECT_NEAR(model.errorOf(kMeter).yaw_rad, 0.09, 0.005);
}

TEST(OdometryModel, TrustsAnExactOdometryMore) {
  const OdometryModel model = modelOf(1500, [](const Pose2& step, int) { return step; });
  EXPECT_LT(model.errorOf(kMeter).position_m, 0.03);
  EXPECT_LT(model.errorOf(kMeter).yaw_rad, 0.01);
}

TEST(OdometryModel, CorrectsAWrongScale) {
  const OdometryModel model = modelOf(
      1000, [](const Pose2& step, int) { return Pose2(0.9 * step.x, 0.9 * step.y, step.yaw); });
  EXPECT_NEAR(model.corrected(Pose2(0.9, 0.0, 0.0)).x, 1.0, 0.02);
  EXPECT_LT(model.errorOf(kMeter).position_m, 0.05);
}

TEST(OdometryModel, CorrectsATurnPerMeter) {
  const OdometryModel model = modelOf(1000, [](const Pose2& step, int) {
    return Pose2(step.x, step.y, step.yaw + 0.05 * step.distance());
  });
  EXPECT_NEAR(model.corrected(Pose2(1.0, 0.0, 0.05)).yaw, 0.0, 0.01);
}

TEST(OdometryModel, DoesNotTrustUnsignedMotion) {
  const OdometryModel model = modelOf(1000, [](const Pose2& step, int i) {
    return i % 100 < 50 ? step : Pose2(-step.x, step.y, step.yaw);
  });
  EXPECT_GT(model.errorOf(kMeter).position_m, 0.5);
}

TEST(OdometryModel, WithoutTheDirectionTheRestIsKnown) {
  OdometryModel model;
  for (int i = 0; i < 1500; ++i) {
    const Pose2 step(0.2, 0.0, 0.1 * std::sin(0.1 * i));
    const Pose2 truth = i % 200 < 100 ? step : reversed(step);
    model.learn(step, truth);
    model.follow(step, truth);
  }
  EXPECT_LT(model.errorAlongDirection(kMeter).position_m, 0.05);
  EXPECT_GT(model.errorOf(kMeter).position_m, 0.1) << "the direction may change";
}

TEST(OdometryModel, ASlipIsNoSystematicError) {
  const OdometryModel model = modelOf(1000, [](const Pose2& step, int i) {
    return i % 150 == 149 ? step * Pose2(0.5, 0.0, 0.0) : step;
  });
  EXPECT_NEAR(model.corrected(kMeter).x, 1.0, 0.01);
}

TEST(OdometryModel, StaysFiniteAfterALongStraightDrive) {
  OdometryModel model;
  for (int i = 0; i < 100000; ++i) model.learn(kMeter, kMeter);
  EXPECT_TRUE(model.corrected(kMeter).isFinite());
  EXPECT_TRUE(std::isfinite(model.errorOf(Pose2(1.0, 0.0, 1.0)).yaw_rad));
}

/// The map is a straight wall on each side: nothing shows the motion along them.
TEST(OdometryModel, CarriesAlongACorridorWithScansFarApart) {
  const std::vector<room::Segment> corridor = {{-500, -1.2F, 500, -1.2F}, {-500, 1.2F, 500, 1.2F}};
  Mapper mapper{MapperConfig()};
  MapperResult result;
  for (int i = 0; i < 30; ++i) {
    const Pose2 truth(1.0 * i, 0.0, 0.0);
    PlanarScan scan = room::scanFrom(Pose2(), corridor);  // looks the same everywhere
    scan.stamp = scan.time = 2.0 * i;
    result = mapper.process(scan, truth);
    EXPECT_NE(result.state, MatchState::kLost) << i;
  }
  EXPECT_NEAR(result.pose.x, 29.0, 0.5);
}

}  // namespace
}  // namespace kestrel
