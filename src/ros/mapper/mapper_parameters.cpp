// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/mapper_parameters.h"

#include <ros/console.h>

#include <stdexcept>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/private_parameters.h"
#include "kestrel_slam/ros/mapper/foreign_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

/// Parameters of hector_mapping and of other nodes that have no effect here.
UnneededParameters unneededParameters() {
  static const std::string kGrows = "the map has no fixed size, it grows as the vehicle explores";
  static const std::string kNoDebug = "the node reports on /diagnostics and slam_cloud";
  UnneededParameters unneeded = {
      {"map_size", kGrows},
      {"map_start_x", kGrows},
      {"map_start_y", kGrows},
      {"map_multi_res_levels", "the matcher chooses its resolutions itself"},
      {"use_tf_scan_transformation", "the mounting of the laser is always taken from tf"},
      {"use_tf_pose_start_estimate", "the odometry is used whenever odom_frame is set"},
      {"pub_drawings", kNoDebug},
      {"pub_debug_output", kNoDebug},
      {"output_timing", "the time per scan is in /diagnostics"},
  };
  unneeded.merge(foreignParameters());
  SlamConfig slam;
  addUnneeded(attitudeParametersOf(slam), "only scan_projector_node uses the attitude", unneeded);
  return unneeded;
}

/// Parameters of hector_mapping that had no limits there.
const std::set<std::string>& hectorNumbers() {
  static const std::set<std::string> names = {"map_resolution",
                                              "update_factor_free",
                                              "update_factor_occupied",
                                              "map_update_distance_thresh",
                                              "map_update_angle_thresh",
                                              "map_pub_period",
                                              "laser_min_dist",
                                              "laser_max_dist",
                                              "laser_z_min_value",
                                              "laser_z_max_value",
                                              "scan_subscriber_queue_size"};
  return names;
}

/// The prefix of a frame with its slash: "uav1/" for "uav1/base_link".
std::string prefixOf(const std::string& frame) { return frame.substr(0, frame.rfind('/') + 1); }

/// The known poses are the odometry's, or those of map_frame -> base_frame if others publish
/// map_frame -> odom_frame, too.
void resolveKnownPoses(MapperNodeConfig& config) {
  if (config.usesOdometry() && config.pub_map_odom_transform) return;
  config.odom_frame = config.map_frame;
  config.pub_map_odom_transform = false;
}

/// hector_mapping starts with frames that would make loops in tf. So does this node, without the
/// transform that would be wrong.
void resolveFrames(MapperNodeConfig& config) {
  if (config.slam.mapper.known_poses) {
    resolveKnownPoses(config);
  } else if (config.odom_frame == config.map_frame) {
    ROS_WARN("odom_frame = %s is the same as map_frame: no odometry is used; tf is %s -> %s.",
             config.odom_frame.c_str(), config.map_frame.c_str(), config.base_frame.c_str());
    config.odom_frame.clear();
  }
  std::string& pose_frame = config.tf_map_scanmatch_transform_frame_name;
  if (pose_frame.empty()) pose_frame = prefixOf(config.base_frame) + "scanmatcher_frame";
  if (!config.pub_map_scanmatch_transform) return;
  for (const std::string& other : {config.map_frame, config.base_frame, config.odom_frame}) {
    if (pose_frame != other) continue;
    config.pub_map_scanmatch_transform = false;
    ROS_WARN(
        "tf_map_scanmatch_transform_frame_name = %s is also another frame: this transform is "
        "not published; the pose of the vehicle is in tf as %s.",
        pose_frame.c_str(), config.base_frame.c_str());
    return;
  }
}

/// Removes leading slashes, which tf2 does not accept but launch files for tf1 still contain.
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
  if (config.follow_session && (!config.localizes() || config.session.empty()))
    throw std::invalid_argument("follow_session needs mode localization and session");
  validate(config.slam);
}

std::vector<Parameter> frameParametersOf(MapperNodeConfig& config) {
  return {
      text("base_frame", &config.base_frame,
           "Frame of the vehicle, whose pose is published; with input planar_scan: "
           "base_footprint_frame of scan_projector_node."),
      text("map_frame", &config.map_frame, "Frame of the map and of the published poses."),
      text("odom_frame", &config.odom_frame,
           "Frame of an odometry whose motion predicts the pose; empty: there is no odometry."),
      text("tf_map_scanmatch_transform_frame_name", &config.tf_map_scanmatch_transform_frame_name,
           "Frame of the pose that pub_map_scanmatch_transform publishes; empty: scanmatcher_frame "
           "with the prefix of base_frame (uav1/base_link gives uav1/scanmatcher_frame)."),
  };
}

std::vector<Parameter> inputParametersOf(MapperNodeConfig& config) {
  constexpr double kMaxQueue = 10000;
  return {
      choice("input", &config.input, {"scan", "planar_scan"},
             "scan: scans of a laser that stays level; planar_scan: scans of "
             "scan_projector_node."),
      text("scan_topic", &config.scan_topic, "Topic of the laser, with input scan."),
      text("planar_scan_topic", &config.planar_scan_topic,
           "Topic of scan_projector_node, with input planar_scan."),
      text("sys_msg_topic", &config.sys_msg_topic,
           "Topic of commands; the command reset deletes the map."),
      number("scan_subscriber_queue_size", "", &config.scan_subscriber_queue_size, 1.0, kMaxQueue,
             "Number of scans that can wait for matching; a longer queue drops fewer scans under "
             "load, and poses come later."),
  };
}

std::vector<Parameter> outputParametersOf(MapperNodeConfig& config) {
  constexpr double kMinPeriod = 0.1, kMaxPeriod = 3600.0, kMaxTolerance = 60.0;
  return {
      text("pose_update_topic", &config.pose_update_topic,
           "Topic of the published pose with covariance."),
      live(number("map_pub_period", "s", &config.map_pub_period, kMinPeriod, kMaxPeriod,
                  "Time between two published maps; a map that did not change is not published "
                  "again.")),
      number("transform_tolerance", "s", &config.transform_tolerance, 0.0, kMaxTolerance,
             "Time by which map_frame -> odom_frame is dated into the future; a larger value "
             "bridges longer gaps between scans."),
      flag("pub_map_odom_transform", &config.pub_map_odom_transform,
           "Publish map_frame -> odom_frame, or map_frame -> base_frame without odometry; set it "
           "to false if pose_filter_node does so."),
      flag("pub_map_scanmatch_transform", &config.pub_map_scanmatch_transform,
           "Also publish the pose as a frame of its own in tf."),
      flag("pub_odometry", &config.pub_odometry, "Also publish the pose on scanmatch_odom."),
      flag("advertise_map_service", &config.advertise_map_service,
           "Offer the service dynamic_map."),
      text(
          "save_folder", &config.save_folder,
          "Folder that save_map cannot leave; empty: a relative path stays in the working folder "
          "of the node (~/.ros with roslaunch), an absolute one in this folder, the home folder or "
          "/tmp."),
  };
}

std::vector<Parameter> sessionParametersOf(MapperNodeConfig& config) {
  constexpr double kDay = 1440.0;
  return {
      choice("mode", &config.mode, {"mapping", "localization"},
             "localization: the vehicle is found and followed in the map of map_file or session, "
             "which does not change."),
      text("map_file", &config.map_file,
           "YAML file of a map to localize in, as map_saver writes it; only with mode "
           "localization."),
      text("session", &config.session,
           "Session file that the node continues from its start on; it turns graph on; empty: a "
           "new map."),
      choice("session_start", &config.session_start, {"last", "unknown"},
             "last: the vehicle is where the session ended, up to some decimeters; unknown: old "
             "and new map stay apart until the vehicle was found in the old one."),
      flag("follow_session", &config.follow_session,
           "With mode localization: wait for the file of session, and load it again when it has "
           "changed, as the merged session of several vehicles does."),
      text("session_folder", &config.session_folder,
           "Folder that save_session, load_session and autosave cannot leave; empty: as with "
           "save_folder."),
      number("autosave_minutes", "min", &config.autosave_minutes, 0.0, kDay,
             "Time between two times that the session is saved as autosave.session in "
             "session_folder, if the map has changed; 0: never."),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(MapperNodeConfig& config) {
  return joined(
      {group("Frames", frameParametersOf(config)), group("Inputs", inputParametersOf(config)),
       group("Outputs", outputParametersOf(config)), group("Sessions", sessionParametersOf(config)),
       mappingParametersOf(config.slam), projectionParametersOf(config.slam)});
}

MapperNodeConfig loadParameters(const ros::NodeHandle& private_nh) {
  MapperNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), unneededParameters(), hectorNumbers());
  tidyFrames(config);
  resolveFrames(config);
  if (!config.session.empty()) config.slam.mapper.window.enabled = true;
  if (config.localizesInPicture()) config.slam.mapper.window.enabled = false;
  validate(config);
  return config;
}

}  // namespace kestrel
