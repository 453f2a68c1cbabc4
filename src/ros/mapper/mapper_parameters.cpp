// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/mapper_parameters.h"

#include <map>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

/// Parameters of hector_mapping, and of libraries, that the node knows and does not need.
const std::map<std::string, std::string>& unneededParameters() {
  static const std::string kGrows = "the map has no fixed size, it grows with what is seen";
  static const std::string kNoDebug = "the node reports on /diagnostics and slam_cloud";
  static const std::map<std::string, std::string> table = {
      {"map_size", kGrows},
      {"map_start_x", kGrows},
      {"map_start_y", kGrows},
      {"map_multi_res_levels", "the matcher chooses its resolutions itself"},
      {"use_tf_scan_transformation", "the mounting of the laser is always taken from tf"},
      {"use_tf_pose_start_estimate", "the odometry is used whenever odom_frame is set"},
      {"map_with_known_poses", "the pose always comes from matching"},
      {"pub_drawings", kNoDebug},
      {"pub_debug_output", kNoDebug},
      {"output_timing", "the time per scan is in /diagnostics"},
  };
  return table;
}

/// tf2 knows no leading slashes, which launch files written for tf1 still have.
void tidyFrames(MapperNodeConfig& config) {
  for (std::string* frame : {&config.base_frame, &config.map_frame, &config.odom_frame,
                             &config.tf_map_scanmatch_transform_frame_name}) {
    *frame = withoutSlash(*frame);
  }
}

void validate(const MapperNodeConfig& config) {
  requireName("base_frame", config.base_frame);
  requireName("map_frame", config.map_frame);
  requireName(config.usesPlanarScans() ? "planar_scan_topic" : "scan_topic", config.inputTopic());
  requireName("sys_msg_topic", config.sys_msg_topic);
  requireName("pose_update_topic", config.pose_update_topic);
  requireDistinct("map_frame", config.map_frame, config.base_frame);
  requireDistinct("odom_frame", config.odom_frame, config.map_frame);
  if (config.pub_map_scanmatch_transform) {
    const std::string& frame = config.tf_map_scanmatch_transform_frame_name;
    requireName("tf_map_scanmatch_transform_frame_name", frame);
    for (const std::string& other : {config.map_frame, config.base_frame, config.odom_frame}) {
      requireDistinct("tf_map_scanmatch_transform_frame_name", frame, other);
    }
  }
  validate(config.slam);
}

}  // namespace

std::vector<Parameter> parametersOf(MapperNodeConfig& config) {
  using namespace parameter_table;
  constexpr double kMaxQueue = 10000, kMinPeriod = 0.1, kMaxPeriod = 3600.0, kMaxTolerance = 60.0;
  std::vector<Parameter> parameters = {
      text("base_frame", &config.base_frame, "the vehicle's frame"),
      text("map_frame", &config.map_frame, "the frame of map and poses"),
      text("odom_frame", &config.odom_frame, "the odometry's frame; empty: no odometry"),
      choice("input", &config.input, {"scan", "planar_scan"},
             "scan: of a laser that stays level; planar_scan: of the scan projector"),
      text("scan_topic", &config.scan_topic, "the laser's topic"),
      text("planar_scan_topic", &config.planar_scan_topic, "the scan projector's topic"),
      text("sys_msg_topic", &config.sys_msg_topic, "topic of commands; 'reset' forgets the map"),
      text("pose_update_topic", &config.pose_update_topic, "topic of the pose with covariance"),
      number("scan_subscriber_queue_size", "", &config.scan_subscriber_queue_size, 1.0, kMaxQueue,
             "scans that may wait for being matched"),
      number("map_pub_period", "s", &config.map_pub_period, kMinPeriod, kMaxPeriod,
             "the map is published this often, if it changed"),
      number("transform_tolerance", "s", &config.transform_tolerance, 0.0, kMaxTolerance,
             "how far the transform map -> odom is dated into the future"),
      flag("pub_map_odom_transform", &config.pub_map_odom_transform,
           "publish map -> odom, or map -> base without odometry"),
      flag("pub_map_scanmatch_transform", &config.pub_map_scanmatch_transform,
           "publish the pose as a frame of its own, too"),
      text("tf_map_scanmatch_transform_frame_name", &config.tf_map_scanmatch_transform_frame_name,
           "the name of that frame"),
      flag("pub_odometry", &config.pub_odometry, "publish the pose on scanmatch_odom, too"),
      flag("advertise_map_service", &config.advertise_map_service, "offer dynamic_map"),
  };
  for (const Parameter& parameter : parametersOf(config.slam)) parameters.push_back(parameter);
  return parameters;
}

MapperNodeConfig loadParameters(const ros::NodeHandle& private_nh) {
  MapperNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), unneededParameters());
  tidyFrames(config);
  validate(config);
  return config;
}

}  // namespace kestrel
