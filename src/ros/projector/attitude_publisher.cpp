// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/attitude_publisher.h"

#include <geometry_msgs/TransformStamped.h>

#include <vector>

#include "kestrel_slam/ros/common/stamps.h"

namespace kestrel {
namespace {

// A larger jump back means that a replay was restarted.
constexpr double kClockJump = 2.0;  // s

geometry_msgs::TransformStamped transformOf(const ros::Time& stamp, const std::string& parent,
                                            const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.rotation.w = 1.0;
  return message;
}

}  // namespace

AttitudePublisher::AttitudePublisher(const ProjectorNodeConfig& config)
    : base_frame_(config.base_frame),
      stabilized_frame_(config.base_stabilized_frame),
      footprint_frame_(config.base_footprint_frame),
      publishes_stabilized_(config.publishesStabilized()),
      publishes_footprint_(config.pub_footprint_transform) {}

void AttitudePublisher::publish(const ros::Time& stamp, const Eigen::Quaterniond& stabilized_R_base,
                                const std::optional<double>& height_m) {
  if (!isNew(stamp)) return;
  last_ = stamp;
  std::vector<geometry_msgs::TransformStamped> transforms;
  if (publishes_stabilized_) {
    transforms.push_back(transformOf(stamp, stabilized_frame_, base_frame_));
    geometry_msgs::Quaternion& rotation = transforms.back().transform.rotation;
    rotation.w = stabilized_R_base.w();
    rotation.x = stabilized_R_base.x();
    rotation.y = stabilized_R_base.y();
    rotation.z = stabilized_R_base.z();
  }
  if (publishes_footprint_) {
    transforms.push_back(transformOf(stamp, footprint_frame_, stabilized_frame_));
    transforms.back().transform.translation.z = height_m.value_or(0.0);
  }
  if (!transforms.empty()) broadcaster_.sendTransform(transforms);
}

bool AttitudePublisher::isNew(const ros::Time& stamp) const {
  return stamp > last_ || secondsBetween(stamp, last_) > kClockJump;
}

}  // namespace kestrel
