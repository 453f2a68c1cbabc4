// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/filtered_motion.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

FilteredMotion motionAt(double stamp) {
  FilteredMotion motion;
  motion.stamp = stamp;
  motion.odom_R_base = Eigen::Quaterniond::Identity();
  motion.odom_T_base = Pose2(stamp, 0.0, 0.0);
  motion.gives_attitude = motion.gives_prediction = true;
  return motion;
}

/// A recording that starts again after any time must not be refused until it passes its old end.
TEST(FilteredMotionBuffer, AnyJumpBackClears) {
  for (const double jump : {0.5, 3.0, 9.0, 100.0}) {
    FilteredMotionBuffer buffer{AttitudeBufferConfig()};
    for (double t = 1000.0; t < 1020.0; t += 0.01) ASSERT_TRUE(buffer.add(motionAt(t)));
    const double start = 1020.0 - jump;
    EXPECT_TRUE(buffer.add(motionAt(start))) << jump;
    EXPECT_TRUE(buffer.add(motionAt(start + 0.01))) << jump;
    EXPECT_TRUE(buffer.odomPose(start + 0.005)) << jump;
    EXPECT_TRUE(buffer.runs(start + 0.02)) << jump;
  }
}

TEST(FilteredMotionBuffer, ARepeatedStampIsNotUsed) {
  FilteredMotionBuffer buffer{AttitudeBufferConfig()};
  EXPECT_TRUE(buffer.add(motionAt(10.0)));
  EXPECT_FALSE(buffer.add(motionAt(10.0)));
  EXPECT_TRUE(buffer.add(motionAt(10.01)));
}

/// One wrong stamp must not make the projector wait forever for a filter that does not run.
TEST(FilteredMotionBuffer, AStateFarInTheFutureDoesNotCount) {
  FilteredMotionBuffer buffer{AttitudeBufferConfig()};
  EXPECT_TRUE(buffer.add(motionAt(5000.0)));
  EXPECT_TRUE(buffer.runs(5000.0));
  EXPECT_FALSE(buffer.runs(1000.0));
}

}  // namespace
}  // namespace kestrel
