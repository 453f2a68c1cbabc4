// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <Eigen/Core>
#include <string>

#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"

namespace kestrel {

/// Receives odometry and passes its velocity to the projection, which corrects the motion during a
/// sweep.
class VelocityInput {
 public:
  VelocityInput(ros::NodeHandle nh, const ProjectorNodeConfig& config, ProjectionStage& projection);

 private:
  void onOdometry(const nav_msgs::OdometryConstPtr& message);

  std::string base_frame_;
  ProjectionStage& projection_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
