// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/filter/pose_filter_parameters.h"

#include <iterator>
#include <map>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/filter_parameters.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

/// Parameters of hector_pose_estimation, and what does their job here.
const std::map<std::string, std::string>& unneededParameters() {
  static const std::map<std::string, std::string> table = {
      {"nav_frame", "the pose is published in ~odom_frame, the correction to ~map_frame by tf"},
      {"publish_covariances", "they always are"},
  };
  return table;
}

std::vector<Parameter> nodeParametersOf(PoseFilterNodeConfig& config) {
  return {
      text("base_frame", &config.base_frame, "the vehicle's frame"),
      text("base_stabilized_frame", &config.base_stabilized_frame,
           "heights in this frame are upright, not along a slanted beam"),
      text("base_footprint_frame", &config.base_footprint_frame,
           "the vehicle's frame down on the floor: child of odom_frame in tf"),
      text("map_frame", &config.map_frame, "the frame of the poses on pose_topic"),
      text("odom_frame", &config.odom_frame, "the smooth frame of odom/filtered"),
      text("imu_topic", &config.imu_topic, "topic of the IMU"),
      text("mapper_topic", &config.mapper_topic,
           "topic of the states of kestrel_slam's own mapper; empty: none"),
      text("pose_topic", &config.pose_topic,
           "topic of the poses of another mapper; they are ignored while mapper_topic gives "
           "states; empty: none"),
      text("height_topic", &config.height_topic,
           "topic of a range finder that looks down; empty: none"),
      text("floor_height_topic", &config.floor_height_topic,
           "topic of the height by the laser's own beams on the floor; empty: none"),
      text("pressure_topic", &config.pressure_topic, "topic of a barometer; empty: none"),
      text("pressure_height_topic", &config.pressure_height_topic,
           "topic of a barometer whose driver gives a height; empty: none"),
      text("magnetometer_topic", &config.magnetometer_topic,
           "topic of a magnetometer, where the map's x axis points east; empty: none"),
      text("fix_topic", &config.fix_topic,
           "topic of GPS fixes, where the map's x axis points east; empty: none"),
      number("magnetic_declination", "rad", &config.magnetic_declination, -kPi, kPi,
             "of the place, positive to the east"),
      flag("pub_map_odom_transform", &config.pub_map_odom_transform,
           "publish map_frame -> odom_frame"),
      flag("pub_odom_base_transform", &config.pub_odom_base_transform,
           "publish odom_frame -> base_footprint_frame"),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(PoseFilterNodeConfig& config) {
  std::vector<Parameter> all = nodeParametersOf(config);
  std::vector<Parameter> of_filter = parametersOf(config.filter);
  all.insert(all.end(), std::make_move_iterator(of_filter.begin()),
             std::make_move_iterator(of_filter.end()));
  return all;
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
