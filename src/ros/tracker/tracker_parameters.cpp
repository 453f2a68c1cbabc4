// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/tracker/tracker_parameters.h"

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/parameters/parameter_table.h"
#include "kestrel_slam/parameters/tracking_parameters.h"
#include "kestrel_slam/ros/common/private_parameters.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> nodeParametersOf(TrackerNodeConfig& config) {
  return {
      text("scan_topic", &config.scan_topic, "Topic of the planar scans of scan_projector_node."),
      text("odom_frame", &config.odom_frame,
           "Frame of the tracks. Its transform to the frame of the scans must not jump; without "
           "odometry and pose filter it is the map frame."),
      number("max_wait", "s", &config.max_wait_s, 0.0, 10.0,
             "Time that a scan waits for its transform; then it is dropped."),
      number("dynamic_grid_radius", "m", &config.dynamic_grid_radius, 1.0, 100.0,
             "The dynamic grid is published this far around the vehicle."),
      number("dynamic_grid_period", "s", &config.dynamic_grid_period, 0.05, 60.0,
             "Period of the dynamic grid. It is only made while somebody listens."),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(TrackerNodeConfig& config) {
  return joined({group("Node", nodeParametersOf(config)), parametersOf(config.tracker)});
}

TrackerNodeConfig loadTrackerParameters(const ros::NodeHandle& private_nh) {
  TrackerNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), {});
  config.odom_frame = withoutSlash(config.odom_frame);
  requireName("scan_topic", config.scan_topic);
  requireName("odom_frame", config.odom_frame);
  return config;
}

}  // namespace kestrel
