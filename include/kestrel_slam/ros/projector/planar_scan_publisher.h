// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>

#include <optional>
#include <string>

#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// Publishes the projected sweep: planar_scan, its view as a LaserScan if there are subscribers,
/// and the heights measured by mirror beams and by beams on the floor.
class PlanarScanPublisher {
 public:
  PlanarScanPublisher(ros::NodeHandle nh, const ProjectorNodeConfig& config);

  void publish(const ros::Time& stamp, const PlanarScan& scan);
  /// Call it also for a sweep without a planar scan.
  void publishHeights(const ros::Time& stamp, const Projection& projection);

 private:
  void publishHeight(const ros::Time& stamp, const std::optional<double>& height_m,
                     ros::Publisher& publisher);

  std::string frame_;
  double view_increment_rad_, range_max_m_;
  ros::Publisher scan_publisher_, view_publisher_, height_publisher_, floor_height_publisher_;
};

}  // namespace kestrel
