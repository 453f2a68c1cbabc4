// SPDX-License-Identifier: BSD-3-Clause
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr const char* kHelp =
    "replay_transforms: passes the tf of a recording on, without the transforms that the mapper\n"
    "publishes itself. Otherwise two nodes would publish the same transform, and it would jump.\n"
    "\n"
    "Subscribes tf_recorded and tf_static_recorded; publishes /tf and /tf_static.\n"
    "Left out: all transforms from map_frame, and those to odom_frame. Where odom_frame is empty:\n"
    "those to base_frame that are not static.\n"
    "\n"
    "Parameters: ~map_frame (map), ~odom_frame (empty), ~base_frame (base_link)\n"
    "Usual start: roslaunch kestrel_slam replay.launch bag:=/absolute/path.bag\n";

class ReplayTransforms {
 public:
  ReplayTransforms() {
    ros::NodeHandle node, parameters("~");
    map_frame_ = withoutSlash(parameters.param<std::string>("map_frame", "map"));
    odom_frame_ = withoutSlash(parameters.param<std::string>("odom_frame", ""));
    base_frame_ = withoutSlash(parameters.param<std::string>("base_frame", "base_link"));
    tf_ = node.advertise<tf2_msgs::TFMessage>("/tf", kQueue);
    tf_static_ = node.advertise<tf2_msgs::TFMessage>("/tf_static", kQueue, true);
    recorded_ = node.subscribe("tf_recorded", kQueue, &ReplayTransforms::passOn, this);
    recorded_static_ =
        node.subscribe("tf_static_recorded", kQueue, &ReplayTransforms::passOnStatic, this);
  }

 private:
  static constexpr int kQueue = 1000;

  void passOn(const tf2_msgs::TFMessage& recorded) {
    const tf2_msgs::TFMessage kept = filtered(recorded, false);
    if (!kept.transforms.empty()) tf_.publish(kept);
  }

  /// A recording may have several latched messages. One node can latch only one.
  void passOnStatic(const tf2_msgs::TFMessage& recorded) {
    for (const auto& transform : filtered(recorded, true).transforms) {
      static_[transform.child_frame_id] = transform;
    }
    tf2_msgs::TFMessage all;
    for (const auto& [child, transform] : static_) all.transforms.push_back(transform);
    tf_static_.publish(all);
  }

  tf2_msgs::TFMessage filtered(const tf2_msgs::TFMessage& recorded, bool is_static) {
    tf2_msgs::TFMessage kept;
    for (const auto& transform : recorded.transforms) {
      const std::string parent = withoutSlash(transform.header.frame_id);
      const std::string child = withoutSlash(transform.child_frame_id);
      const bool replaced =
          odom_frame_.empty() ? child == base_frame_ && !is_static : child == odom_frame_;
      if (parent != map_frame_ && !replaced) {
        kept.transforms.push_back(transform);
      } else if (named_.insert(parent + " -> " + child).second) {
        ROS_WARN("the recording has tf %s -> %s, which the mapper replaces: it is left out",
                 parent.c_str(), child.c_str());
      }
    }
    return kept;
  }

  std::string map_frame_, odom_frame_, base_frame_;
  std::map<std::string, geometry_msgs::TransformStamped> static_;  ///< by child frame
  std::set<std::string> named_;                                    ///< left out and reported
  ros::Publisher tf_, tf_static_;
  ros::Subscriber recorded_, recorded_static_;
};

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  const bool help = std::any_of(argv + 1, argv + argc, [](const std::string& argument) {
    return argument == "--help" || argument == "-h";
  });
  if (help) {
    std::fputs(kestrel::kHelp, stdout);
    return 0;
  }
  ros::init(argc, argv, "replay_transforms");
  const kestrel::ReplayTransforms node;
  ros::spin();
  return 0;
}
