// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/placed_keyframe.h"

#include <gtest/gtest.h>

#include <memory>

namespace kestrel {
namespace {

PlacedKeyframe keyframeAt(double stamp, const Pose2& map_T_base,
                          const Pose2& submap_T_base = Pose2()) {
  auto keyframe = std::make_shared<Keyframe>();
  keyframe->stamp = stamp;
  keyframe->submap_T_base = submap_T_base;
  return {keyframe, map_T_base};
}

TEST(MapMotion, IsThatOfTheNearestCommonKeyframe) {
  const Pose2 moved(3.0, -2.0, 0.5), moved_more(5.0, 1.0, 0.6);
  const Pose2 first(1.0, 0.0, 0.2), second(8.0, 1.0, 1.0), only_before(4.1, 0.0, 0.0);
  const std::vector<PlacedKeyframe> before = {keyframeAt(1.0, first), keyframeAt(2.0, second),
                                              keyframeAt(3.0, only_before)};
  const std::vector<PlacedKeyframe> after = {keyframeAt(2.0, moved_more * second),
                                             keyframeAt(1.0, moved * first),
                                             keyframeAt(4.0, Pose2(4.0, 0.0, 0.0))};
  const auto near_first = mapMotionAt(Pose2(4.0, 0.0, 0.0), before, after);
  ASSERT_TRUE(near_first);
  EXPECT_LT(near_first->between(moved).distance(), 1e-12);
  EXPECT_NEAR(near_first->yaw, moved.yaw, 1e-12);
  const auto near_second = mapMotionAt(Pose2(6.0, 0.0, 0.0), before, after);
  ASSERT_TRUE(near_second);
  EXPECT_LT(near_second->between(moved_more).distance(), 1e-12);
}

TEST(MapMotion, IsUnknownWithoutACommonKeyframe) {
  EXPECT_FALSE(mapMotionAt(Pose2(), {keyframeAt(1.0, Pose2())}, {keyframeAt(2.0, Pose2())}));
  EXPECT_FALSE(mapMotionAt(Pose2(), {}, {}));
}

/// Two vehicles with clocks that agree.
TEST(MapMotion, TellsScansOfTheSameTimeApart) {
  const Pose2 in_submap(0.4, 0.1, 0.0), other(7.0, 0.1, 0.0);
  const std::vector<PlacedKeyframe> before = {keyframeAt(1.0, Pose2(1.0, 0.0, 0.0), in_submap)};
  const std::vector<PlacedKeyframe> after = {keyframeAt(1.0, Pose2(9.0, 9.0, 1.0), other),
                                             keyframeAt(1.0, Pose2(1.5, 0.0, 0.0), in_submap),
                                             keyframeAt(1.0, Pose2(8.0, 8.0, 1.0), other)};
  const auto motion = mapMotionAt(Pose2(), before, after);
  ASSERT_TRUE(motion);
  EXPECT_NEAR(motion->x, 0.5, 1e-12);
}

}  // namespace
}  // namespace kestrel
