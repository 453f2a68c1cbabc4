// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/projector_parameters.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

/// The node's own one takes its place: it knows tf and none as well.
constexpr char kAttitudeSource[] = "attitude_source";

/// Parameters of laser_ortho_projector, and what does their job here.
const std::map<std::string, std::string>& unneededParameters() {
  static const std::map<std::string, std::string> table = {
      {"ortho_frame", "the scans are published in ~base_stabilized_frame"},
      {"fixed_frame", "~attitude_frame names the frame that tf has the attitude in"},
      {"use_imu", "~attitude_source says where the attitude comes from"},
      {"use_pose", "~attitude_source says where the attitude comes from"},
      {"publish_tf", "~pub_stabilized_transform and ~pub_footprint_transform switch tf"},
  };
  return table;
}

std::vector<Parameter> nodeParametersOf(ProjectorNodeConfig& config) {
  constexpr double kMaxWait = 10.0, kMaxQueue = 10000, kMinIncrement = 1e-4, kMaxIncrement = 0.5;
  return {
      text("base_frame", &config.base_frame, "the vehicle's frame"),
      text("base_stabilized_frame", &config.base_stabilized_frame,
           "the vehicle's frame without roll and pitch, in which scans are published"),
      text("base_footprint_frame", &config.base_footprint_frame, "the same, down on the floor"),
      text("scan_topics", &config.scan_topics,
           "topics of the lasers, with commas between them or as a list; empty: none"),
      text("cloud_topic", &config.cloud_topic, "topic of a 3D lidar; empty: none"),
      text("imu_topic", &config.imu_topic, "topic of the IMU"),
      text("height_topic", &config.height_topic,
           "topic of a range finder that looks down; where mirror_angles are given, of their "
           "height; empty: none"),
      text("odom_topic", &config.odom_topic, "topic of an odometry with the velocity; empty: none"),
      text(
          "filter_topic", &config.filter_topic,
          "topic of the states of the pose filter, filtered_motion: its attitude, velocity, height "
          "and motion are used while they are known well; empty: none"),
      choice(kAttitudeSource, &config.attitude_source, {"auto", "orientation", "raw", "tf", "none"},
             "the IMU's orientation, or its gyro and accelerometer (auto: what it gives); tf; or "
             "none for a laser that is always level"),
      text("attitude_frame", &config.attitude_frame,
           "attitude from tf: the frame whose z axis points up; empty: base_stabilized_frame"),
      choice("without_imu", &config.without_imu, {"drop", "level"},
             "what happens to scans where the IMU fails: dropped, or taken to be level"),
      number("max_wait", "s", &config.max_wait_s, 0.0, kMaxWait,
             "how long a scan waits for its attitude and transform"),
      number("queue_size", "", &config.queue_size, 1.0, kMaxQueue,
             "scans that may wait; beyond that the oldest are dropped"),
      flag("pub_stabilized_transform", &config.pub_stabilized_transform,
           "publish base_stabilized_frame -> base_frame; never where the attitude is from tf"),
      flag("pub_footprint_transform", &config.pub_footprint_transform,
           "publish base_footprint_frame -> base_stabilized_frame"),
      number("view_increment", "rad", &config.view_increment_rad, kMinIncrement, kMaxIncrement,
             "angle between the beams of planar_scan_view"),
  };
}

/// tf2 knows no leading slashes, which launch files written for tf1 still have.
void tidyFrames(ProjectorNodeConfig& config) {
  for (std::string* frame : {&config.base_frame, &config.base_stabilized_frame,
                             &config.base_footprint_frame, &config.attitude_frame}) {
    *frame = withoutSlash(*frame);
  }
  if (config.attitude_frame.empty()) config.attitude_frame = config.base_stabilized_frame;
}

void validate(const ProjectorNodeConfig& config) {
  requireName("base_frame", config.base_frame);
  requireName("base_stabilized_frame", config.base_stabilized_frame);
  requireName("base_footprint_frame", config.base_footprint_frame);
  requireDistinct("base_stabilized_frame", config.base_stabilized_frame, config.base_frame);
  requireDistinct("base_footprint_frame", config.base_footprint_frame, config.base_frame);
  requireDistinct("base_footprint_frame", config.base_footprint_frame,
                  config.base_stabilized_frame);
  if (config.usesTf()) {
    requireDistinct("attitude_frame", config.attitude_frame, config.base_frame);
  }
  if (config.usesImu()) requireName("imu_topic", config.imu_topic);
  if (splitNames(config.scan_topics).empty() && config.cloud_topic.empty()) {
    throw std::invalid_argument("scan_topics and cloud_topic are empty: one must name a laser");
  }
  validate(config.slam);
}

}  // namespace

std::vector<std::string> splitNames(const std::string& text) {
  std::string spaced = text;
  std::replace(spaced.begin(), spaced.end(), ',', ' ');
  std::istringstream stream(spaced);
  std::vector<std::string> names;
  for (std::string name; stream >> name;) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<Parameter> parametersOf(ProjectorNodeConfig& config) {
  std::vector<Parameter> parameters = nodeParametersOf(config);
  for (const Parameter& parameter : projectorParametersOf(config.slam)) {
    if (parameter.name != kAttitudeSource) parameters.push_back(parameter);
  }
  return parameters;
}

ProjectorNodeConfig loadProjectorParameters(const ros::NodeHandle& private_nh) {
  ProjectorNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), unneededParameters());
  tidyFrames(config);
  if (config.usesImu()) config.slam.attitude.source = config.attitude_source;
  validate(config);
  return config;
}

}  // namespace kestrel
