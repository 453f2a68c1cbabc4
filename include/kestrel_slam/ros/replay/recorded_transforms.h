// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <set>
#include <string>
#include <vector>

namespace kestrel {

/// The transforms of `message` whose child frame is not in `own`. The others are appended to
/// `left_out`.
tf2_msgs::TFMessage withoutChildren(const tf2_msgs::TFMessage& message,
                                    const std::set<std::string>& own,
                                    std::vector<geometry_msgs::TransformStamped>& left_out);

/// Passes the transforms of a recording from recorded/tf to /tf, except those that the nodes of the
/// replay publish themselves. Two publishers of one transform would make tf jump.
class RecordedTransforms {
 public:
  /// Private parameter `own_frames`: child frames, separated by commas.
  RecordedTransforms(ros::NodeHandle nh, ros::NodeHandle private_nh);

 private:
  tf2_msgs::TFMessage filtered(const tf2_msgs::TFMessage& message);

  std::set<std::string> own_;
  std::set<std::string> reported_;  ///< of own_
  ros::Publisher publisher_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  ros::Subscriber subscriber_, static_subscriber_;
};

}  // namespace kestrel
