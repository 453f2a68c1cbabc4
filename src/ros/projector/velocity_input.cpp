// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/velocity_input.h"

#include <ros/console.h>

#include <cmath>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 20;
constexpr double kMaxSpeed = 100.0;     // m/s; higher speeds are invalid
constexpr double kComplainEvery = 5.0;  // s

}  // namespace

VelocityInput::VelocityInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                             ProjectionStage& projection)
    : base_frame_(config.base_frame), projection_(projection) {
  if (config.odom_topic.empty()) return;
  subscriber_ = subscribeGuarded<nav_msgs::Odometry>(
      nh, config.odom_topic, kQueue,
      [this](const nav_msgs::OdometryConstPtr& message) { onOdometry(message); });
}

void VelocityInput::onOdometry(const nav_msgs::OdometryConstPtr& message) {
  const geometry_msgs::Vector3& linear = message->twist.twist.linear;
  Eigen::Vector3d velocity(linear.x, linear.y, linear.z);
  if (!(velocity.norm() < kMaxSpeed)) {  // false for NaN
    KESTREL_WARN_THROTTLE(kComplainEvery, "A velocity on %s is not used: %g m/s.",
                          subscriber_.getTopic().c_str(), velocity.norm());
    return;
  }
  const AttitudeBuffer& attitudes = projection_.tracker().buffer();
  Attitude attitude;
  const bool is_tilted = withoutSlash(message->child_frame_id) == base_frame_;
  const std::optional<double> latest = attitudes.latest();
  if (is_tilted && latest && attitudes.lookup(*latest, attitude) == AttitudeError::kNone) {
    velocity = attitude.stabilized_R_base * velocity;
  }
  projection_.addVelocity(toSeconds(message->header.stamp), velocity.head<2>(),
                          message->twist.twist.angular.z);
}

}  // namespace kestrel
