// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/odometry_error.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace kestrel {
namespace {

/// Motions along a straight line, m per step.
std::vector<Pose2> distort(const std::string& errors, int steps, double step_m) {
  OdometryDistortion distortion(parseOdometryError(errors));
  std::vector<Pose2> poses;
  for (int i = 0; i <= steps; ++i) poses.push_back(distortion.next(Pose2(1.0 + i * step_m, 0, 0)));
  return poses;
}

TEST(OdometryErrorTest, WithoutErrorsTheOdometryStaysAsItIs) {
  const std::vector<Pose2> poses = distort("", 10, 1.0);
  EXPECT_EQ(poses.front().x, 1.0);
  EXPECT_NEAR(poses.back().x, 11.0, 1e-12);
  EXPECT_EQ(poses.back().yaw, 0.0);
}

TEST(OdometryErrorTest, ShortMakesEveryDistanceShorter) {
  EXPECT_NEAR(distort("short:0.1", 10, 1.0).back().x, 1.0 + 9.0, 1e-12);
  EXPECT_NEAR(distort("short:0.1", 10, -1.0).back().x, 1.0 - 9.0, 1e-12);
}

TEST(OdometryErrorTest, TurnIsProportionalToTheDistanceAndNotToTheTime) {
  EXPECT_NEAR(distort("turn:0.02", 10, 1.0).back().yaw, 0.2, 1e-12);
  EXPECT_NEAR(distort("turn:0.02", 100, 0.1).back().yaw, 0.2, 1e-9);
  EXPECT_EQ(distort("turn:0.02", 100, 0.0).back().yaw, 0.0);
}

TEST(OdometryErrorTest, UnsignedCountsBackwardAsForward) {
  EXPECT_NEAR(distort("unsigned", 5, -1.0).back().x, 1.0 + 5.0, 1e-12);
  EXPECT_NEAR(distort("unsigned", 5, 1.0).back().x, 1.0 + 5.0, 1e-12);
}

TEST(OdometryErrorTest, SlipsHaveTheirLengthAndComeEvery30Meters) {
  const std::vector<Pose2> poses = distort("slip:0.5", 3000, 1.0);
  int slips = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Pose2 motion = poses[i - 1].between(poses[i]);
    const double slip = (motion.translation() - Eigen::Vector2d(1.0, 0.0)).norm();
    if (slip < 1e-9) continue;
    EXPECT_NEAR(slip, 0.5, 1e-9);
    ++slips;
  }
  EXPECT_NEAR(slips, 100, 40);  // 4 sigma
  EXPECT_EQ(distort("slip:0.5", 3000, 1.0).back().x, poses.back().x) << "the seed is fixed";
}

TEST(OdometryErrorTest, ErrorsCanBeCombined) {
  const OdometryError error = parseOdometryError("short:0.1,turn:0.02,unsigned,slip:0.5");
  EXPECT_EQ(error.short_share, 0.1);
  EXPECT_EQ(error.turn_rad_per_m, 0.02);
  EXPECT_TRUE(error.is_unsigned);
  EXPECT_EQ(error.slip_m, 0.5);
}

TEST(OdometryErrorTest, RefusesWhatIsNoError) {
  for (const char* text : {"long:0.1", "short", "short:", "short:x", "unsigned:1", "short:0.1,,"}) {
    EXPECT_THROW(parseOdometryError(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace kestrel
