// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/tracking/tracker_config.h"

namespace kestrel {

/// All parameters of the tracker's node.
struct TrackerNodeConfig {
  std::string input = "auto";  ///< auto, planar_scan or points
  std::string scan_topic = "planar_scan";
  std::string cloud_topic = "points";
  std::string odom_frame = "odom";
  bool cloud_odometry = false;
  std::string base_frame;  ///< with cloud_odometry; empty: the frame of the clouds
  double max_wait_s = 0.5;
  double dynamic_grid_radius = 10.0;  ///< m
  double dynamic_grid_period = 0.5;   ///< s
  TrackerConfig tracker;
  CloudTrackerConfig cloud;

  bool takesScans() const { return input != "points"; }
  bool takesClouds() const { return input != "planar_scan"; }
};

std::vector<Parameter> parametersOf(TrackerNodeConfig& config);

/// Reads the private parameters; see readPrivateParameters. Throws std::invalid_argument.
TrackerNodeConfig loadTrackerParameters(const ros::NodeHandle& private_nh);

}  // namespace kestrel
