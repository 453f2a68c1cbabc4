// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "kestrel_slam/filter/pose_filter_config.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// All parameters of the pose filter's node.
struct PoseFilterNodeConfig {
  std::string base_frame = "base_link";
  std::string base_stabilized_frame = "base_stabilized";
  std::string base_footprint_frame = "base_footprint";
  std::string map_frame = "map";
  std::string odom_frame = "odom";
  std::string imu_topic = "imu/data";
  std::string mapper_topic = "mapper_state";  ///< of our own mapper
  std::string pose_topic = "poseupdate";      ///< of another mapper
  std::string height_topic = "height";
  std::string height_sensor_z;                            ///< m; empty: from tf
  std::string floor_height_topic = "floor_height";        ///< of the projector
  std::string pressure_topic = "imu/pressure";            ///< pressure of a barometer
  std::string pressure_height_topic = "pressure_height";  ///< height of a barometer
  std::string magnetometer_topic;     ///< empty: none; indoors, steel disturbs the field
  std::string fix_topic;              ///< empty: none
  double magnetic_declination = 0.0;  ///< at the location, rad, positive to the east
  bool pub_map_odom_transform = true;
  bool pub_odom_base_transform = true;
  PoseFilterConfig filter;
};

/// The table of the node's parameters and those of the filter, bound to `config`.
std::vector<Parameter> parametersOf(PoseFilterNodeConfig& config);

/// Reads the private parameters; see readPrivateParameters. Throws std::invalid_argument.
PoseFilterNodeConfig loadPoseFilterParameters(const ros::NodeHandle& private_nh);

}  // namespace kestrel
