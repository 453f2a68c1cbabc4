// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/transform_input.h"

#include <gtest/gtest.h>

#include "kestrel_slam/ros/replay/recorded_transforms.h"

namespace kestrel {
namespace {

const std::vector<OwnTransform> kOwn = {{"map", "odom", "Stop it."},
                                        {"base_stabilized", "base_link", "Stop it."}};

std::string rival(const std::string& publisher, const std::string& parent,
                  const std::string& child) {
  return rivalSentence(kOwn, "/mapper", publisher, parent, child);
}

TEST(Rivals, AreNamed) {
  EXPECT_EQ(rival("/amcl", "map", "odom"),
            "tf: /amcl publishes map -> odom, this node map -> odom: tf will jump. Stop it.");
  EXPECT_NE(rival("/robot_state_publisher", "base_footprint", "base_link"), "");
  EXPECT_NE(rival("/mapper", "world", "odom"), "") << "another nodelet of the same process";
}

TEST(Rivals, OtherTransformsAreNone) {
  EXPECT_EQ(rival("/mapper", "map", "odom"), "");
  EXPECT_EQ(rival("/robot_state_publisher", "base_link", "laser"), "");
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  return message;
}

TEST(RecordedTransforms, OwnFramesAreLeftOut) {
  tf2_msgs::TFMessage message;
  message.transforms = {transform("map", "/odom"), transform("odom", "base_link"),
                        transform("base_link", "laser")};
  std::vector<geometry_msgs::TransformStamped> left_out;
  const tf2_msgs::TFMessage kept = withoutChildren(message, {"odom"}, left_out);
  ASSERT_EQ(kept.transforms.size(), 2U);
  EXPECT_EQ(kept.transforms[0].child_frame_id, "base_link");
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out[0].child_frame_id, "/odom");
}

}  // namespace
}  // namespace kestrel
