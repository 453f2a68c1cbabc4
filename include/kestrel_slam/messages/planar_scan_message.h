// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <string>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// A planar scan as a message (msg/PlanarScan.msg). `stamp` is the recorded stamp of the scan, its
/// name and reference time. Nothing is rounded.
kestrel_slam::PlanarScanPtr toPlanarScanMessage(const PlanarScan& scan, const std::string& frame,
                                                const ros::Time& stamp);

/// The inverse. Throws std::invalid_argument that names what is wrong: arrays of different lengths,
/// a number that is not finite.
PlanarScan fromPlanarScanMessage(const kestrel_slam::PlanarScan& message);

/// The hits as a LaserScan around the base, for packages that know nothing else: in every bin of
/// `angle_increment` (rad) the nearest hit, +inf where rays only clear, NaN where there is no ray.
sensor_msgs::LaserScanPtr toLaserScanView(const PlanarScan& scan, const std::string& frame,
                                          const ros::Time& stamp, double angle_increment,
                                          double range_max);

}  // namespace kestrel
