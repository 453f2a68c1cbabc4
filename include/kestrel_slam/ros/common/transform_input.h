// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>
#include <tf2_ros/buffer.h>

#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/stamps.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {

/// A transform that this node publishes.
struct OwnTransform {
  std::string parent, child;
  std::string advice;  ///< what to do if another node publishes it too
};

/// Receives tf into a buffer. In contrast to tf2_ros::TransformListener, wrong stamps are refused,
/// no exception leaves the callback, and other publishers of the own transforms are named in the
/// log.
///
/// tf is received on the thread of `nh`: tf2 is not safe if a message filter looks up frames while
/// another thread adds them.
class TransformInput {
 public:
  TransformInput(tf2_ros::Buffer& buffer, const ros::NodeHandle& nh,
                 std::vector<OwnTransform> own = {});
  TransformInput(const TransformInput&) = delete;
  TransformInput& operator=(const TransformInput&) = delete;

 private:
  using Event = ros::MessageEvent<const tf2_msgs::TFMessage>;

  void receive(const Event& event, bool is_static);
  void add(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
           bool is_static);
  void warnOfRival(const geometry_msgs::TransformStamped& transform, const std::string& publisher);
  void noticeJump();

  tf2_ros::Buffer& buffer_;
  std::vector<OwnTransform> own_;
  std::map<std::string, StampGate> gates_;         ///< by child frame
  std::map<std::string, WallThrottle> throttles_;  ///< by child frame of own_
  ros::Time last_now_;
  ros::NodeHandle nh_;
  ros::Subscriber subscriber_, static_subscriber_;
};

/// The sentence about another publisher of a transform that `own` lists. Empty if there is no
/// conflict. `self`: the name of this node.
std::string rivalSentence(const std::vector<OwnTransform>& own, const std::string& self,
                          const std::string& publisher, const std::string& parent,
                          const std::string& child);

}  // namespace kestrel
