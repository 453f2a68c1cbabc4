// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// All parameters of the scan projector's node.
struct ProjectorNodeConfig {
  std::string base_frame = "base_link";
  std::string base_stabilized_frame = "base_stabilized";
  std::string base_footprint_frame = "base_footprint";
  std::string scan_topics = "scan";  ///< names separated by commas
  std::string cloud_topic = "points";
  std::string imu_topic = "imu/data";
  std::string height_topic = "height";
  std::string height_sensor_z;  ///< m; empty: from tf
  std::string odom_topic = "odom/slam";
  std::string filter_topic;              ///< topic of a pose filter; empty: none
  std::string attitude_source = "auto";  ///< auto, orientation, raw: IMU; tf; none: level
  std::string attitude_frame;            ///< tf: a frame with z up; empty: base_stabilized_frame
  std::string without_imu = "drop";      ///< or level
  double max_wait_s = 0.1;
  int queue_size = 20;
  bool pub_stabilized_transform = true;
  bool pub_footprint_transform = true;
  double view_increment_rad = 0.004363323;  ///< a quarter of a degree
  SlamConfig slam;                          ///< only `projector` and `attitude` are used

  bool isLevel() const { return attitude_source == "none"; }
  bool usesTf() const { return attitude_source == "tf"; }
  bool usesImu() const { return !isLevel() && !usesTf(); }
  /// If the attitude comes from tf, the base already has a parent.
  bool publishesStabilized() const { return pub_stabilized_transform && !usesTf(); }
  bool hasMirror() const { return !slam.projector.mirror_angles.empty(); }
};

/// The table of the node's parameters and those of the projector, bound to `config`.
std::vector<Parameter> parametersOf(ProjectorNodeConfig& config);

/// Reads the private parameters; see readPrivateParameters. Throws std::invalid_argument.
ProjectorNodeConfig loadProjectorParameters(const ros::NodeHandle& private_nh);

}  // namespace kestrel
