// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

namespace kestrel {

/// Where the sensors sit on the vehicle, by tf. Never waits. `nh` must be served by one thread.
class Mountings {
 public:
  Mountings(const ros::NodeHandle& nh, const std::string& base_frame);

  /// base_T_sensor; nothing as long as tf does not know it.
  std::optional<Eigen::Isometry3d> lookup(const std::string& sensor_frame) const;

  /// A sentence about a mounting that tf lacks. `sensor`: "laser", "IMU".
  std::string missing(const std::string& sensor, const std::string& sensor_frame) const;

  const tf2_ros::Buffer& buffer() const { return buffer_; }
  const std::string& baseFrame() const { return base_frame_; }

 private:
  std::string base_frame_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

}  // namespace kestrel
