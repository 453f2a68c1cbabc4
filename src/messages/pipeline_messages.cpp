// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/pipeline_messages.h"

#include <cmath>
#include <limits>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

geometry_msgs::Vector3 toMessage(const Eigen::Vector3d& v) {
  geometry_msgs::Vector3 message;
  message.x = v.x();
  message.y = v.y();
  message.z = v.z();
  return message;
}

Eigen::Vector3d fromMessage(const geometry_msgs::Vector3& v) { return {v.x, v.y, v.z}; }

MatchState stateOf(std::uint8_t state) {
  if (state == kestrel_slam::MapperState::OK) return MatchState::kOk;
  return state == kestrel_slam::MapperState::DEGRADED ? MatchState::kDegraded : MatchState::kLost;
}

std::uint8_t numberOf(MatchState state) {
  if (state == MatchState::kOk) return kestrel_slam::MapperState::OK;
  return state == MatchState::kDegraded ? kestrel_slam::MapperState::DEGRADED
                                        : kestrel_slam::MapperState::LOST;
}

}  // namespace

kestrel_slam::FilteredMotion toMessage(const FilteredMotion& motion, const ros::Time& stamp,
                                       const std::string& odom_frame) {
  kestrel_slam::FilteredMotion message;
  message.header.stamp = stamp;
  message.header.frame_id = odom_frame;
  message.orientation.w = motion.odom_R_base.w();
  message.orientation.x = motion.odom_R_base.x();
  message.orientation.y = motion.odom_R_base.y();
  message.orientation.z = motion.odom_R_base.z();
  message.angular_velocity = toMessage(motion.angular_velocity);
  message.specific_force = toMessage(motion.specific_force);
  message.x = motion.odom_T_base.x;
  message.y = motion.odom_T_base.y;
  message.yaw = motion.odom_T_base.yaw;
  message.velocity_x = motion.velocity.x();
  message.velocity_y = motion.velocity.y();
  message.height = motion.height_m.value_or(std::numeric_limits<double>::quiet_NaN());
  message.gives_attitude = motion.gives_attitude;
  message.gives_prediction = motion.gives_prediction;
  return message;
}

FilteredMotion fromMessage(const kestrel_slam::FilteredMotion& message) {
  FilteredMotion motion;
  motion.stamp = toSeconds(message.header.stamp);
  const auto& q = message.orientation;
  motion.odom_R_base = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
  motion.angular_velocity = fromMessage(message.angular_velocity);
  motion.specific_force = fromMessage(message.specific_force);
  motion.odom_T_base = Pose2(message.x, message.y, message.yaw);
  motion.velocity = {message.velocity_x, message.velocity_y};
  if (std::isfinite(message.height)) motion.height_m = message.height;
  motion.gives_attitude = message.gives_attitude != 0;
  motion.gives_prediction = message.gives_prediction != 0;
  return motion;
}

kestrel_slam::MapperState toMessage(const MatchedPose& pose, const ros::Time& stamp,
                                    const std::string& map_frame) {
  kestrel_slam::MapperState message;
  message.header.stamp = stamp;
  message.header.frame_id = map_frame;
  message.state = numberOf(pose.state);
  message.x = pose.pose.x;
  message.y = pose.pose.y;
  message.yaw = pose.pose.yaw;
  Eigen::Map<RowMajor>(message.covariance.data()) = pose.covariance;
  message.velocity_x = pose.velocity.x();
  message.velocity_y = pose.velocity.y();
  message.unobservable_x = pose.unobservable.x();
  message.unobservable_y = pose.unobservable.y();
  return message;
}

MatchedPose fromMessage(const kestrel_slam::MapperState& message) {
  MatchedPose pose;
  pose.stamp = toSeconds(message.header.stamp);
  pose.pose = Pose2(message.x, message.y, message.yaw);
  pose.covariance = Eigen::Map<const RowMajor>(message.covariance.data());
  pose.velocity = {message.velocity_x, message.velocity_y};
  pose.state = stateOf(message.state);
  pose.unobservable = {message.unobservable_x, message.unobservable_y};
  return pose;
}

}  // namespace kestrel
