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
      choice("input", &config.input, {"auto", "planar_scan", "points"},
             "planar_scan: a planar laser; points: a 3D lidar; auto: the one that sends first."),
      text("scan_topic", &config.scan_topic, "Topic of the planar scans of scan_projector_node."),
      text("cloud_topic", &config.cloud_topic,
           "Topic of the clouds of a 3D lidar (sensor_msgs/PointCloud2)."),
      text("odom_frame", &config.odom_frame,
           "Frame of the tracks. Its transform to the frame of the scans must not jump; without "
           "odometry and pose filter it is the map frame."),
      flag("cloud_odometry", &config.cloud_odometry,
           "true: nothing else publishes the transform from odom_frame. The tracker finds it by "
           "the clouds, and publishes it."),
      text("base_frame", &config.base_frame,
           "With cloud_odometry: the frame that gets the transform from odom_frame; tf must have "
           "its transform to the frame of the clouds. Empty: the frame of the clouds."),
      number("max_wait", "s", &config.max_wait_s, 0.0, 10.0,
             "Time that a scan or cloud waits for its transform; then it is dropped."),
      number("dynamic_grid_radius", "m", &config.dynamic_grid_radius, 1.0, 100.0,
             "The dynamic grid is published this far around the vehicle."),
      number("dynamic_grid_period", "s", &config.dynamic_grid_period, 0.05, 60.0,
             "Period of the dynamic grid. It is only made while somebody listens."),
  };
}

std::vector<Parameter> cloudMapParametersOf(CloudTrackerConfig& config) {
  return {
      number("cloud_min_range", "m", &config.min_range_m, 0.0, 10.0,
             "Nearer returns are from the vehicle."),
      number("cloud_max_range", "m", &config.max_range_m, 5.0, 1000.0,
             "Farther returns are not used."),
      number("cloud_free_range", "m", &config.free_range_m, 5.0, 1000.0,
             "Beams clear cells up to this distance; objects are found within it."),
      number("cloud_surface_resolution", "m", &config.surface_resolution_m, 0.1, 2.0,
             "Voxels of the map for the localization, and distance of the matched points."),
      number("cloud_grid_resolution", "m", &config.grid.resolution_m, 0.1, 2.0,
             "Voxels of the static and the dynamic grid."),
      number("cloud_wall_tolerance", "m", &config.grid.tolerance_m, 0.0, 2.0,
             "A return this near to something static belongs to it; larger for a poor pose."),
      number("cloud_ring_step", "°", &config.ring_step_deg, 0.05, 10.0,
             "Angle between the rings of the lidar."),
      number("cloud_memory_limit", "MB", &config.grid.memory_limit_mb, 10.0, 100000.0,
             "Largest size of the static and the dynamic grid."),
  };
}

std::vector<Parameter> cloudObjectParametersOf(CloudTrackerConfig& config) {
  return {
      number("cloud_bandwidth", "m", &config.bandwidth_m, 0.1, 10.0,
             "Bandwidth of the mean shift; larger joins pedestrians who walk together."),
      number("cloud_join_gap", "m", &config.join_gap_m, 0.0, 10.0,
             "Voxels with gaps up to this are one object."),
      number("cloud_max_height", "m", &config.max_height_m, -10.0, 100.0,
             "Objects have their lowest point at most this far above the lidar."),
      number("cloud_max_speed", "m/s", &config.max_speed, 0.1, 100.0,
             "Largest speed of something in unknown space that is not tracked yet."),
      number("cloud_coast_time", "s", &config.coast_s, 0.1, 60.0,
             "A visible object that gives no return is forgotten after this time."),
      number("cloud_hidden_time", "s", &config.hidden_s, 0.1, 60.0,
             "An object that is hidden is forgotten after this time."),
      number("cloud_moved_distance", "m", &config.moved_m, 0.0, 10.0,
             "An object is shown when it has moved by more than this."),
      number("cloud_acceleration_sigma", "m/s²", &config.acceleration_sigma, 0.01, 100.0,
             "How much objects change their velocity."),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(TrackerNodeConfig& config) {
  return joined({group("Node", nodeParametersOf(config)), parametersOf(config.tracker),
                 group("3D lidar: maps", cloudMapParametersOf(config.cloud)),
                 group("3D lidar: objects", cloudObjectParametersOf(config.cloud))});
}

TrackerNodeConfig loadTrackerParameters(const ros::NodeHandle& private_nh) {
  TrackerNodeConfig config;
  readPrivateParameters(private_nh, parametersOf(config), {});
  config.odom_frame = withoutSlash(config.odom_frame);
  config.base_frame = withoutSlash(config.base_frame);
  requireName("odom_frame", config.odom_frame);
  if (config.takesScans()) requireName("scan_topic", config.scan_topic);
  if (config.takesClouds()) requireName("cloud_topic", config.cloud_topic);
  if (config.cloud_odometry) requireDistinct("base_frame", config.base_frame, config.odom_frame);
  return config;
}

}  // namespace kestrel
