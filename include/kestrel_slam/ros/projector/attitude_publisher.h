// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/ros/projector/projector_parameters.h"

namespace kestrel {

/// Publishes tf base_footprint -> base_stabilized -> base: height, then roll and pitch.
class AttitudePublisher {
 public:
  explicit AttitudePublisher(const ProjectorNodeConfig& config);

  /// Publishes at most once per stamp. `height_m`: height of the base above the floor, if known.
  void publish(const ros::Time& stamp, const Eigen::Quaterniond& stabilized_R_base,
               const std::optional<double>& height_m);

 private:
  bool isNew(const ros::Time& stamp) const;

  std::string base_frame_, stabilized_frame_, footprint_frame_;
  bool publishes_stabilized_, publishes_footprint_;
  ros::Time last_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace kestrel
