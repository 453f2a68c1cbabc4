// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/filter/pose_filter_parameters.h"

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/filter_parameters.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

constexpr double kMaxDeclination = 3.15;  // rad; half a turn

/// Parameters of hector_pose_estimation that have no effect here.
const UnneededParameters& unneededParameters() {
  static const UnneededParameters table = {
      {"nav_frame", "the pose is published in ~odom_frame, the correction to ~map_frame by tf"},
      {"publish_covariances", "covariances are always published"},
  };
  return table;
}

std::vector<Parameter> frameParametersOf(PoseFilterNodeConfig& config) {
  return {
      text("base_frame", &config.base_frame, "Frame of the vehicle."),
      text("base_stabilized_frame", &config.base_stabilized_frame,
           "Frame of the vehicle without roll and pitch; heights in it are taken as vertical."),
      text("base_footprint_frame", &config.base_footprint_frame,
           "Frame on the floor below the vehicle; it is the child of odom_frame in tf."),
      text("map_frame", &config.map_frame, "Frame of the poses on mapper_topic and pose_topic."),
      text("odom_frame", &config.odom_frame,
           "Frame of odom/filtered, in which the pose never jumps."),
  };
}

std::vector<Parameter> inputParametersOf(PoseFilterNodeConfig& config) {
  return {
      text("imu_topic", &config.imu_topic, "Topic of the IMU."),
      text("mapper_topic", &config.mapper_topic,
           "Topic of the states of mapper_node; empty: none."),
      text("pose_topic", &config.pose_topic,
           "Topic of the poses of another mapper; they are ignored while states come on "
           "mapper_topic; empty: none."),
      text("height_topic", &config.height_topic,
           "Topic of a range finder that looks down; empty: none."),
      text(
          "height_sensor_z", &config.height_sensor_z,
          "Height of the range finder in base_frame (m), if it looks straight down and tf does not "
          "have its mounting; empty: from tf."),
      text("floor_height_topic", &config.floor_height_topic,
           "Topic of the height that scan_projector_node measures with laser beams on the floor; "
           "empty: none."),
      text("pressure_topic", &config.pressure_topic,
           "Topic of a barometer that gives a pressure; empty: none."),
      text("pressure_height_topic", &config.pressure_height_topic,
           "Topic of a barometer whose driver gives a height; empty: none."),
      text("magnetometer_topic", &config.magnetometer_topic,
           "Topic of a magnetometer; the x axis of map_frame must point east; empty: none."),
      text("fix_topic", &config.fix_topic,
           "Topic of GPS fixes; the x axis of map_frame must point east; empty: none."),
      number("magnetic_declination", "rad", &config.magnetic_declination, -kMaxDeclination,
             kMaxDeclination, "Magnetic declination of the place, positive to the east."),
  };
}

std::vector<Parameter> outputParametersOf(PoseFilterNodeConfig& config) {
  return {
      flag("pub_map_odom_transform", &config.pub_map_odom_transform,
           "Publish map_frame -> odom_frame."),
      flag("pub_odom_base_transform", &config.pub_odom_base_transform,
           "Publish odom_frame -> base_footprint_frame."),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(PoseFilterNodeConfig& config) {
  return joined({group("Frames", frameParametersOf(config)),
                 group("Inputs", inputParametersOf(config)),
                 group("Outputs", outputParametersOf(config)), parametersOf(config.filter)});
}

PoseFilterNodeConfig loadPoseFilterParameters(const ros::NodeHandle& private_nh) {
  PoseFilterNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), unneededParameters());
  for (std::string* frame : {&config.base_frame, &config.base_stabilized_frame,
                             &config.base_footprint_frame, &config.map_frame, &config.odom_frame}) {
    *frame = withoutSlash(*frame);
  }
  requireName("base_frame", config.base_frame);
  requireName("base_footprint_frame", config.base_footprint_frame);
  requireName("map_frame", config.map_frame);
  requireName("odom_frame", config.odom_frame);
  requireName("imu_topic", config.imu_topic);
  requireDistinct("odom_frame", config.odom_frame, config.map_frame);
  requireDistinct("base_footprint_frame", config.base_footprint_frame, config.odom_frame);
  validate(config.filter);
  return config;
}

}  // namespace kestrel
