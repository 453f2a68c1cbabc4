// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/ros/filter/pose_filter_parameters.h"

namespace kestrel {

/// Publishes every state of the filter: odom/filtered, height/filtered, imu/bias and tf.
class FilterPublisher {
 public:
  FilterPublisher(ros::NodeHandle nh, const PoseFilterNodeConfig& config);

  /// `stamp`: the stamp of the IMU message. States that are not finite are not published.
  void publish(const ros::Time& stamp, const FilterOutput& output, double imu_rate_hz);

 private:
  void publishOdometry(const ros::Time& stamp, const FilterOutput& output, double imu_rate_hz);
  void publishMotion(const ros::Time& stamp, const FilterOutput& output);
  void publishHeight(const ros::Time& stamp, const FilterOutput& output);
  void publishBias(const ros::Time& stamp, const FilterOutput& output);
  void publishTransforms(const ros::Time& stamp, const FilterOutput& output);

  PoseFilterNodeConfig config_;
  ros::Publisher odometry_publisher_, motion_publisher_, height_publisher_, bias_publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace kestrel
