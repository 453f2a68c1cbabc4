// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/OccupancyGrid.h>

#include <Eigen/Geometry>
#include <string>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/ros/tracker/followed.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

/// Tracks with planar scans, in the frame `odom_frame`.
class ScanFollower {
 public:
  ScanFollower(const TrackerConfig& config, std::string odom_frame);

  /// Throws std::invalid_argument if the message is damaged.
  Followed follow(const kestrel_slam::PlanarScan& message, const Eigen::Isometry3d& odom_T_base);
  /// The dynamic grid within `radius` (m) of the vehicle.
  nav_msgs::OccupancyGrid grid(double radius, const ros::Time& stamp) const;

 private:
  std::string frame_;
  Tracker tracker_;
  Pose2 odom_T_base_;
  double last_stamp_ = 0.0;
};

}  // namespace kestrel
