// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/continuous_pose.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(ContinuousPose, FollowsThePosesOfTheMapper) {
  ContinuousPose continuous;
  for (int i = 0; i < 10; ++i) {
    const Pose2 pose(1.0 + 0.1 * i, 2.0, 0.05 * i);
    const Pose2 result = continuous.add(0.1 * i, pose, false);
    EXPECT_NEAR((result.inverse() * pose).distance(), 0.0, 1e-9);
  }
}

TEST(ContinuousPose, TakesTheOdometryWhereTheMapperJumps) {
  ContinuousPose continuous;
  continuous.add(0.0, Pose2(0, 0, 0), false, Pose2(5, 5, 0));
  const Pose2 jumped = continuous.add(0.1, Pose2(8, 0, 1), true, Pose2(5.2, 5, 0));
  EXPECT_NEAR(jumped.x, 0.2, 1e-9);
  const Pose2 after =
      continuous.add(0.2, Pose2(8, 0, 1) * Pose2(0.1, 0, 0), false, Pose2(5.3, 5, 0));
  EXPECT_NEAR(after.x, 0.3, 1e-9);
  EXPECT_NEAR(after.y, 0.0, 1e-9);
}

TEST(ContinuousPose, TakesTheLastMotionWithoutOdometry) {
  ContinuousPose continuous;
  continuous.add(0.0, Pose2(0, 0, 0), false);
  continuous.add(0.1, Pose2(0.1, 0, 0), false);
  const Pose2 jumped = continuous.add(0.3, Pose2(9, 9, 2), true);
  EXPECT_NEAR(jumped.x, 0.3, 1e-9);
  EXPECT_NEAR(jumped.y, 0.0, 1e-9);
}

}  // namespace
}  // namespace kestrel
