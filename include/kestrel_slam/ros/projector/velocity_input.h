// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <Eigen/Core>
#include <string>

#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {

/// The velocity of the vehicle from an odometry, to undo the motion during a sweep.
class VelocityInput {
 public:
  /// `attitude`: turns the velocity of a tilted base; it must outlive this.
  VelocityInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                const AttitudeBuffer& attitude);

  /// In base_stabilized at `time` (s), m/s; zero where nothing recent is known.
  Eigen::Vector2d velocity(double time) const;

 private:
  void onOdometry(const nav_msgs::OdometryConstPtr& message);

  std::string base_frame_;
  const AttitudeBuffer& attitude_;
  double stamp_ = 0.0;  ///< s
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
