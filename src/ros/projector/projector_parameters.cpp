// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/projector_parameters.h"

#include <algorithm>
#include <stdexcept>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/names.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

/// The node has its own parameter with this name and the additional choices tf and none.
constexpr char kAttitudeSource[] = "attitude_source";

/// Parameters of laser_ortho_projector and of other nodes that have no effect here.
UnneededParameters unneededParameters() {
  static const std::string kSource = "~attitude_source sets the source of the attitude";
  UnneededParameters unneeded = {
      {"ortho_frame", "the scans are published in ~base_stabilized_frame"},
      {"fixed_frame", "~attitude_frame is the frame whose attitude is taken from tf"},
      {"use_imu", kSource},
      {"use_pose", kSource},
      {"filter_height_topic", "the height of the pose filter is received on ~filter_topic"},
      {"publish_tf", "~pub_stabilized_transform and ~pub_footprint_transform turn tf on or off"},
  };
  SlamConfig slam;
  addUnneeded(mappingParametersOf(slam), "only mapper_node builds a map", unneeded);
  return unneeded;
}

std::vector<Parameter> frameParametersOf(ProjectorNodeConfig& config) {
  return {
      text("base_frame", &config.base_frame, "Frame of the vehicle."),
      text("base_stabilized_frame", &config.base_stabilized_frame,
           "Frame of the vehicle without roll and pitch, in which the planar scans are "
           "published."),
      text("base_footprint_frame", &config.base_footprint_frame,
           "Frame without roll and pitch on the floor below the vehicle."),
  };
}

std::vector<Parameter> inputParametersOf(ProjectorNodeConfig& config) {
  return {
      text("scan_topics", &config.scan_topics,
           "Topics of the lasers, separated by commas or as a list; empty: none."),
      text("cloud_topic", &config.cloud_topic, "Topic of a 3D lidar; empty: none."),
      text("imu_topic", &config.imu_topic, "Topic of the IMU."),
      text("height_topic", &config.height_topic,
           "Topic of a range finder that looks down; with mirror_angles the node publishes its "
           "height there; empty: none."),
      text(
          "height_sensor_z", &config.height_sensor_z,
          "Height of the range finder in base_frame (m), if it looks straight down and tf does not "
          "have its mounting; empty: from tf."),
      text("odom_topic", &config.odom_topic,
           "Topic of an odometry whose velocity corrects the motion during a scan; empty: none."),
      text("filter_topic", &config.filter_topic,
           "Topic filtered_motion of pose_filter_node, whose attitude, velocity, height and motion "
           "are used while they are well known; empty: none."),
  };
}

std::vector<Parameter> attitudeChoicesOf(ProjectorNodeConfig& config) {
  return {
      choice(kAttitudeSource, &config.attitude_source, {"auto", "orientation", "raw", "tf", "none"},
             "orientation: the IMU's own orientation; raw: from its gyro and accelerometer; auto: "
             "the orientation if the IMU gives one, else raw; tf: from tf; none: the laser is "
             "always level."),
      text("attitude_frame", &config.attitude_frame,
           "With attitude_source tf: frame whose z axis points up; empty: "
           "base_stabilized_frame."),
      choice("without_imu", &config.without_imu, {"drop", "level"},
             "What happens to scans while the attitude is missing: drop, or take the vehicle to be "
             "level."),
  };
}

std::vector<Parameter> queueParametersOf(ProjectorNodeConfig& config) {
  constexpr double kMaxWait = 10.0, kMaxQueue = 10000;
  return {
      number("max_wait", "s", &config.max_wait_s, 0.0, kMaxWait,
             "Time that a scan waits for its attitude and transform before it is dropped; a larger "
             "value drops fewer scans if the IMU is late."),
      number("queue_size", "", &config.queue_size, 1.0, kMaxQueue,
             "Number of scans that can wait; if there are more, the oldest is dropped."),
  };
}

std::vector<Parameter> outputParametersOf(ProjectorNodeConfig& config) {
  constexpr double kMinIncrement = 1e-4, kMaxIncrement = 0.5;
  return {
      flag("pub_stabilized_transform", &config.pub_stabilized_transform,
           "Publish base_stabilized_frame -> base_frame; never with attitude_source tf."),
      flag("pub_footprint_transform", &config.pub_footprint_transform,
           "Publish base_footprint_frame -> base_stabilized_frame."),
      number("view_increment", "rad", &config.view_increment_rad, kMinIncrement, kMaxIncrement,
             "Angle between the beams of planar_scan_view; a smaller angle shows more detail."),
  };
}

/// Removes leading slashes, which tf2 does not accept but launch files for tf1 still contain.
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
    throw std::invalid_argument("scan_topics and cloud_topic are empty: set at least one of them");
  }
  validate(config.slam);
}

}  // namespace

std::vector<Parameter> parametersOf(ProjectorNodeConfig& config) {
  std::vector<Parameter> attitude = attitudeParametersOf(config.slam);
  attitude.erase(std::remove_if(attitude.begin(), attitude.end(),
                                [](const Parameter& p) { return p.name == kAttitudeSource; }),
                 attitude.end());
  return joined(
      {group("Frames", frameParametersOf(config)), group("Inputs", inputParametersOf(config)),
       group("Attitude", joined({attitudeChoicesOf(config), attitude})),
       group("Waiting", queueParametersOf(config)), group("Outputs", outputParametersOf(config)),
       projectionParametersOf(config.slam)});
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
