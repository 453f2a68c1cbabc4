// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/transform_input.h"

#include <ros/console.h>
#include <ros/this_node.h>

#include <utility>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 100;  // as in tf2_ros
constexpr double kRemindEvery = 30.0;  // s

}  // namespace

TransformInput::TransformInput(tf2_ros::Buffer& buffer, const ros::NodeHandle& nh,
                               std::vector<OwnTransform> own)
    : buffer_(buffer), own_(std::move(own)), nh_(nh) {
  const auto subscribe = [this](const std::string& topic, bool is_static) {
    const boost::function<void(const Event&)> callback = [this, topic,
                                                          is_static](const Event& event) {
      guarded(topic, [&] { receive(event, is_static); });
    };
    return nh_.subscribe<tf2_msgs::TFMessage>(topic, kQueue, callback);
  };
  subscriber_ = subscribe("/tf", false);
  static_subscriber_ = subscribe("/tf_static", true);
}

void TransformInput::receive(const Event& event, bool is_static) {
  noticeJump();
  const std::string& publisher = event.getPublisherName();
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    guarded("tf", [&] { add(transform, publisher, is_static); });
  }
}

void TransformInput::add(const geometry_msgs::TransformStamped& transform,
                         const std::string& publisher, bool is_static) {
  warnOfRival(transform, publisher);
  if (!is_static) {
    const std::string reason =
        gates_[transform.child_frame_id].refusal(transform.header.stamp, ros::Time::now());
    if (!reason.empty()) return logRefusal("tf from " + publisher, reason);
  }
  buffer_.setTransform(transform, publisher, is_static);
}

/// After the clock was set back, the old data are in the future and hide the new data.
void TransformInput::noticeJump() {
  const ros::Time now = ros::Time::now();
  if (now < last_now_) {
    ROS_WARN("The clock jumps back by %.3f s: tf is cleared.", secondsBetween(now, last_now_));
    buffer_.clear();
  }
  last_now_ = now;
}

void TransformInput::warnOfRival(const geometry_msgs::TransformStamped& transform,
                                 const std::string& publisher) {
  const std::string sentence = rivalSentence(own_, ros::this_node::getName(), publisher,
                                             withoutSlash(transform.header.frame_id),
                                             withoutSlash(transform.child_frame_id));
  if (sentence.empty()) return;
  WallThrottle& throttle =
      throttles_.try_emplace(withoutSlash(transform.child_frame_id), kRemindEvery).first->second;
  if (throttle.due()) ROS_WARN("%s", sentence.c_str());
}

std::string rivalSentence(const std::vector<OwnTransform>& own, const std::string& self,
                          const std::string& publisher, const std::string& parent,
                          const std::string& child) {
  for (const OwnTransform& mine : own) {
    if (child != mine.child || (parent == mine.parent && publisher == self)) continue;
    return "tf: " + publisher + " publishes " + parent + " -> " + child + ", this node " +
           mine.parent + " -> " + mine.child + ": tf will jump. " + mine.advice;
  }
  return "";
}

}  // namespace kestrel
