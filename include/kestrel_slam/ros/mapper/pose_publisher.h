// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <optional>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"

namespace kestrel {

/// Publishes the match result: pose topics, tf, the matched scan and markers of the uncertainty.
class PosePublisher {
 public:
  PosePublisher(ros::NodeHandle nh, const MapperNodeConfig& config);

  /// `odom_T_base`: the odometry at the scan's stamp; needed if the node uses odometry.
  void publish(const ros::Time& stamp, const MapperResult& result, const PlanarScan& scan,
               const std::optional<Pose2>& odom_T_base);

  /// Publishes the last map -> odom again while mapping is paused. Does nothing before the first
  /// match.
  void repeatCorrection(const ros::Time& stamp);

  /// A user has placed the vehicle: `map_T_base` at the time of `odom_T_base`.
  void place(const Pose2& map_T_base, const std::optional<Pose2>& odom_T_base);

  /// Pose in map: the last match plus the motion of the odometry since then. Empty without
  /// odometry.
  std::optional<Pose2> poseByOdometry(const std::optional<Pose2>& odom_T_base) const;

 private:
  void publishPose(const ros::Time& stamp, const MapperResult& result);
  void publishTransforms(const ros::Time& stamp, const Pose2& map_T_base);
  void publishCloud(const ros::Time& stamp, const MapperResult& result, const PlanarScan& scan);
  void publishMarkers(const ros::Time& stamp, const MapperResult& result);
  geometry_msgs::TransformStamped transform(const ros::Time& stamp, const std::string& child,
                                            const Pose2& map_T_child) const;

  MapperNodeConfig config_;
  ros::Publisher state_publisher_, pose_publisher_, pose_update_publisher_, cloud_publisher_;
  ros::Publisher slam_odometry_publisher_, odometry_publisher_, marker_publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::optional<Pose2> map_T_odom_;
  ros::Time transforms_stamp_;  ///< of the last transforms
};

}  // namespace kestrel
