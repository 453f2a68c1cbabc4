#include "kestrel_slam/ros/node_parameters.h"

#include <ros/console.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "kestrel_slam/mapping/parameter_table.h"
#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {
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

/// Of diagnostic_updater, which reads it from the same namespace.
constexpr char kDiagnosticPeriod[] = "diagnostic_period";

/// The shorter of the two decimal forms that give the same number when they are read.
std::string numberText(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.15g", value);
  if (std::strtod(text, nullptr) != value) std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string textOf(const std::string& name, XmlRpc::XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return numberText(static_cast<double>(value));
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    default:
      throw std::invalid_argument(name + ": must be a single value, not a list or a dictionary");
  }
}

/// The names in the private namespace, without it.
std::vector<std::string> privateNames(const ros::NodeHandle& private_nh) {
  const std::string prefix = private_nh.getNamespace() + "/";
  std::vector<std::string> all, names;
  private_nh.getParamNames(all);
  for (const std::string& name : all) {
    if (name.compare(0, prefix.size(), prefix) == 0) names.push_back(name.substr(prefix.size()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

void reportUnused(const ros::NodeHandle& private_nh, const std::vector<Parameter>& parameters) {
  std::vector<std::string> valid;
  for (const Parameter& parameter : parameters) valid.push_back(parameter.name);
  for (const std::string& name : privateNames(private_nh)) {
    if (name == kDiagnosticPeriod) continue;
    if (std::find(valid.begin(), valid.end(), name) != valid.end()) continue;
    const auto unneeded = unneededParameters().find(name);
    if (unneeded != unneededParameters().end()) {
      ROS_INFO("The parameter ~%s has no effect: %s.", name.c_str(), unneeded->second.c_str());
    } else {
      ROS_WARN("Unknown parameter ~%s; did you mean ~%s?", name.c_str(),
               nearestName(name, valid).c_str());
    }
  }
}

void requireName(const char* name, const std::string& value) {
  if (value.empty()) throw std::invalid_argument(std::string(name) + " = '': must not be empty");
}

void requireDistinct(const char* name, const std::string& frame, const std::string& other) {
  if (frame != other) return;
  throw std::invalid_argument(std::string(name) + " = " + frame +
                              ": another frame has this name too, one must change");
}

/// tf2 knows no leading slashes, which launch files written for tf1 still have.
void tidyFrames(NodeConfig& config) {
  for (std::string* frame : {&config.base_frame, &config.map_frame, &config.odom_frame,
                             &config.tf_map_scanmatch_transform_frame_name}) {
    *frame = withoutSlash(*frame);
  }
}

void validate(const NodeConfig& config) {
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

std::vector<Parameter> parametersOf(NodeConfig& config) {
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

NodeConfig loadParameters(const ros::NodeHandle& private_nh) {
  NodeConfig config;
  const std::vector<Parameter> parameters = parametersOf(config);
  reportUnused(private_nh, parameters);
  for (const Parameter& parameter : parameters) {
    XmlRpc::XmlRpcValue value;
    if (private_nh.getParam(parameter.name, value)) {
      setValue(parameter, textOf(parameter.name, value));
    }
  }
  tidyFrames(config);
  validate(config);
  return config;
}

}  // namespace kestrel_slam
