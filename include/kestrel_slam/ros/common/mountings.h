// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/transform_input.h"

namespace kestrel {

/// Looks up the mounting of the sensors on the vehicle in tf. Never blocks. `nh` must be served by
/// one thread.
class Mountings {
 public:
  /// `own`: the transforms that the node publishes.
  Mountings(const ros::NodeHandle& nh, const std::string& base_frame,
            std::vector<OwnTransform> own = {});

  /// base_T_sensor. Empty while tf does not have it.
  std::optional<Eigen::Isometry3d> lookup(const std::string& sensor_frame) const;

  /// A message about a mounting that is missing in tf. `sensor`: "laser", "IMU".
  std::string missing(const std::string& sensor, const std::string& sensor_frame) const;

  const tf2_ros::Buffer& buffer() const { return buffer_; }
  const std::string& baseFrame() const { return base_frame_; }

 private:
  std::string base_frame_;
  tf2_ros::Buffer buffer_;
  TransformInput input_;
};

}  // namespace kestrel
