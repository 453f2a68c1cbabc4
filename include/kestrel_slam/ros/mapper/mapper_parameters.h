// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// All parameters of the mapper node. Names and meanings are those of hector_mapping.
struct MapperNodeConfig {
  std::string base_frame = "base_link";
  std::string map_frame = "map";
  std::string odom_frame;      ///< empty, or the base frame: no odometry, tf is map -> base
  std::string input = "scan";  ///< scan: from a level laser; planar_scan: from the scan projector
  std::string scan_topic = "scan";
  std::string planar_scan_topic = "planar_scan";
  std::string sys_msg_topic = "syscommand";
  std::string pose_update_topic = "poseupdate";
  int scan_subscriber_queue_size = 5;
  double map_pub_period = 2.0;       ///< s
  double transform_tolerance = 0.1;  ///< s; time that is added to the stamp of map -> odom
  bool pub_map_odom_transform = true;
  bool pub_map_scanmatch_transform = true;
  std::string tf_map_scanmatch_transform_frame_name;  ///< empty: derived from the base frame
  bool pub_odometry = false;
  bool advertise_map_service = true;
  std::string save_folder;       ///< empty: the working, home and temporary folder
  std::string mode = "mapping";  ///< or localization, in `map_file` or `session`
  std::string map_file;          ///< YAML file of a map
  std::string session;           ///< file that is continued from the start on; empty: none
  std::string session_start = "last";
  bool follow_session = false;    ///< with localization: load `session` again when it has changed
  std::string session_folder;     ///< empty: the working, home and temporary folder
  double autosave_minutes = 0.0;  ///< 0: never
  SlamConfig slam;

  bool localizes() const { return mode == "localization"; }
  bool localizesInPicture() const { return localizes() && !map_file.empty(); }
  bool usesPlanarScans() const { return input == "planar_scan"; }
  const std::string& inputTopic() const {
    return usesPlanarScans() ? planar_scan_topic : scan_topic;
  }
  std::string inputParameter() const {
    return usesPlanarScans() ? "~planar_scan_topic" : "~scan_topic";
  }
  bool usesOdometry() const { return !odom_frame.empty() && odom_frame != base_frame; }
};

/// The table of the node's parameters and those of map, matching and projection, bound to `config`.
std::vector<Parameter> parametersOf(MapperNodeConfig& config);

/// Reads the private parameters; see readPrivateParameters. Throws std::invalid_argument.
MapperNodeConfig loadParameters(const ros::NodeHandle& private_nh);

}  // namespace kestrel
