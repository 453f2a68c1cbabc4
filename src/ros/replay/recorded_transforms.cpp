// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/replay/recorded_transforms.h"

#include <ros/console.h>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/names.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;

}  // namespace

tf2_msgs::TFMessage withoutChildren(const tf2_msgs::TFMessage& message,
                                    const std::set<std::string>& own,
                                    std::vector<geometry_msgs::TransformStamped>& left_out) {
  tf2_msgs::TFMessage kept;
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    const bool is_own = own.count(withoutSlash(transform.child_frame_id)) > 0;
    (is_own ? left_out : kept.transforms).push_back(transform);
  }
  return kept;
}

RecordedTransforms::RecordedTransforms(ros::NodeHandle nh, ros::NodeHandle private_nh) {
  for (const std::string& frame : splitNames(private_nh.param("own_frames", std::string()))) {
    own_.insert(withoutSlash(frame));
  }
  publisher_ = nh.advertise<tf2_msgs::TFMessage>("/tf", kQueue);
  subscriber_ = subscribeGuarded<tf2_msgs::TFMessage>(
      nh, "recorded/tf", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) {
        const tf2_msgs::TFMessage kept = filtered(*message);
        if (!kept.transforms.empty()) publisher_.publish(kept);
      });
  static_subscriber_ = subscribeGuarded<tf2_msgs::TFMessage>(
      nh, "recorded/tf_static", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) {
        static_broadcaster_.sendTransform(filtered(*message).transforms);
      });
}

tf2_msgs::TFMessage RecordedTransforms::filtered(const tf2_msgs::TFMessage& message) {
  std::vector<geometry_msgs::TransformStamped> left_out;
  tf2_msgs::TFMessage kept = withoutChildren(message, own_, left_out);
  for (const geometry_msgs::TransformStamped& transform : left_out) {
    if (!reported_.insert(withoutSlash(transform.child_frame_id)).second) continue;
    ROS_WARN(
        "The recording has its own %s -> %s in tf. It is left out, because this launch file "
        "publishes that frame.",
        transform.header.frame_id.c_str(), transform.child_frame_id.c_str());
  }
  return kept;
}

}  // namespace kestrel
