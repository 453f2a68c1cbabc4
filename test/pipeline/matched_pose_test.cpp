// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/matched_pose.h"

#include <gtest/gtest.h>

namespace kestrel {
namespace {

TEST(MatchedPose, OnlyAMeasuredMotionCorrectsTheNextSweep) {
  MapperResult result;
  result.velocity = {1.0, 0.2};
  result.yaw_rate = 0.5;
  result.state = MatchState::kDegraded;
  EXPECT_EQ(knownVelocity(result), result.velocity);
  EXPECT_EQ(knownYawRate(result), 0.5);
  result.carried = true;
  EXPECT_TRUE(knownVelocity(result).isZero());
  EXPECT_EQ(knownYawRate(result), 0.0);
  result.carried = false;
  result.state = MatchState::kLost;
  EXPECT_EQ(knownYawRate(result), 0.0);
}

}  // namespace
}  // namespace kestrel
