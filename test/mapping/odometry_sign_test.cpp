// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_sign.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

constexpr double kErrorM = 0.02;
const Pose2 kStep(0.4, 0.0, 0.02), kBack = reversed(kStep);

/// Drives `steps` of `motion` where the odometry measures `measured`.
void drive(OdometrySign& sign, int steps, const Pose2& motion, const Pose2& measured) {
  for (int i = 0; i < steps; ++i) {
    sign.learn(measured, motion, kErrorM);
    sign.follow(measured, motion, kErrorM);
  }
}

TEST(OdometrySign, ForwardMotionShowsNothing) {
  OdometrySign sign;
  drive(sign, 100, kStep, kStep);
  EXPECT_TRUE(sign.mayBeMissing());
  EXPECT_FALSE(sign.isMissing());
  EXPECT_FALSE(sign.isReversed(kStep, kBack, kErrorM));
}

TEST(OdometrySign, AnOdometryThatCountsBackIsKnownToHaveADirection) {
  OdometrySign sign;
  drive(sign, 1, kBack, kBack);
  EXPECT_FALSE(sign.mayBeMissing());
  drive(sign, 1, kBack, kStep);  // wheels that spin
  EXPECT_FALSE(sign.isMissing());
}

TEST(OdometrySign, AnOdometryThatCountsForwardOnTheWayBackHasNone) {
  OdometrySign sign;
  drive(sign, 20, kStep, kStep);
  drive(sign, 1, kBack, kStep);
  EXPECT_TRUE(sign.isMissing());
  EXPECT_TRUE(sign.isReversed(kStep, kBack, kErrorM));
  EXPECT_FALSE(sign.isReversed(kStep, kStep, kErrorM));
  EXPECT_GT(sign.wrongShare(), 0.0);
}

TEST(OdometrySign, AVehicleThatDrivesBackGoesOnAsItDidBefore) {
  OdometrySign sign;
  for (int i = 0; i < 3; ++i) {
    drive(sign, 10, kStep, kStep);
    drive(sign, 10, kBack, kStep);
  }
  EXPECT_TRUE(sign.isReversedNext());
  EXPECT_LT(sign.wrongShare(), 0.2);
  drive(sign, 1, kStep, kStep);
  EXPECT_FALSE(sign.isReversedNext());
}

TEST(OdometrySign, ShortStepsAreSeenTogether) {
  OdometrySign sign;
  drive(sign, 10, Pose2(-0.05, 0.0, 0.0), Pose2(0.05, 0.0, 0.0));
  EXPECT_TRUE(sign.isMissing());
}

TEST(OdometrySign, ATurnIsNoWayBack) {
  OdometrySign sign;
  drive(sign, 40, Pose2(0.2, 0.0, 0.2), Pose2(0.2, 0.0, 0.2));      // circles
  drive(sign, 40, Pose2(-0.02, 0.01, 0.5), Pose2(0.04, 0.0, 0.5));  // not about the base frame
  EXPECT_TRUE(sign.mayBeMissing());
  EXPECT_FALSE(sign.isMissing());
}

TEST(SignedOdometry, MotionsAgainstItAreReversed) {
  SignedOdometry odometry;
  const Pose2 start(3.0, -1.0, 0.7);
  EXPECT_EQ(*odometry.next(start, false), start);
  const Pose2 turned = start * kStep * Pose2(0.0, 0.0, 1.0);
  EXPECT_EQ(*odometry.next(turned, false), turned) << "as measured";
  const Pose2 measured = turned * kStep;
  const Pose2 back = *odometry.next(measured, true);
  EXPECT_NEAR(turned.between(back).x, -kStep.x, 1e-9);
  const Pose2 on = *odometry.next(measured * kStep, false);
  EXPECT_NEAR(back.between(on).x, kStep.x, 1e-9);
  EXPECT_FALSE(odometry.next(std::nullopt, false));
}

}  // namespace
}  // namespace kestrel
