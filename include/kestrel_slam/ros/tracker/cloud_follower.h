// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/OccupancyGrid.h>
#include <sensor_msgs/PointCloud2.h>

#include <Eigen/Geometry>
#include <string>

#include "kestrel_slam/lidar/cloud_tracker.h"
#include "kestrel_slam/ros/tracker/followed.h"

namespace kestrel {

/// Tracks with the clouds of a 3D lidar, in the frame `odom_frame`.
///
/// The tracker matches the clouds with its own map, so that errors of the odometry make nothing
/// move. What it finds is published where the odometry is now: the transform between both frames
/// changes by the drift of the odometry.
class CloudFollower {
 public:
  CloudFollower(const CloudTrackerConfig& config, std::string odom_frame);

  /// With the pose of the lidar by the odometry. Throws std::invalid_argument if the message is
  /// damaged.
  Followed follow(const sensor_msgs::PointCloud2& message, const Eigen::Isometry3d& odom_T_lidar);
  /// Without odometry: the frame of the tracks is that of the own map, in which the lidar starts at
  /// `start_T_lidar`.
  Followed followAlone(const sensor_msgs::PointCloud2& message,
                       const Eigen::Isometry3d& start_T_lidar);

  /// The dynamic grid within `radius` (m) of the lidar, seen from above.
  nav_msgs::OccupancyGrid grid(double radius, const ros::Time& stamp) const;
  /// Where the lidar is by its clouds.
  const Eigen::Isometry3d& pose() const { return tracker_.pose(); }
  /// False if the pose is only a prediction.
  bool isLocalized() const { return localized_; }

 private:
  /// Empty if the cloud can be used.
  std::string takeOver(const PointCloud& cloud);
  Followed resultOf(const sensor_msgs::PointCloud2& message, const LidarSweep& sweep,
                    const CloudTracker::Result& result);

  std::string odom_frame_;
  CloudTracker tracker_;
  std::string lidar_frame_;  ///< of the clouds that are tracked
  bool localized_ = false;
  Eigen::Isometry3d odom_T_map_ = Eigen::Isometry3d::Identity();
};

}  // namespace kestrel
