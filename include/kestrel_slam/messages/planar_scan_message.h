// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <string>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Converts a planar scan to a message (msg/PlanarScan.msg). `stamp` is the recorded stamp of the
/// scan, which identifies the scan and is its reference time.
kestrel_slam::PlanarScanPtr toPlanarScanMessage(const PlanarScan& scan, const std::string& frame,
                                                const ros::Time& stamp);

/// The inverse conversion. Throws std::invalid_argument with the reason if the arrays have
/// different lengths or a number is not finite.
PlanarScan fromPlanarScanMessage(const kestrel_slam::PlanarScan& message);

/// The hits as a LaserScan around the base, for packages that need this type. Each bin of
/// `angle_increment` (rad) contains the nearest hit, +inf if its rays only mark free space, or NaN
/// if it has no ray.
sensor_msgs::LaserScanPtr toLaserScanView(const PlanarScan& scan, const std::string& frame,
                                          const ros::Time& stamp, double angle_increment,
                                          double range_max);

}  // namespace kestrel
