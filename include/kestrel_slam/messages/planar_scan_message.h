// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <string>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel_slam {

/// A planar scan as a message, one point a ray, all float32: `x`, `y`, `z` (0) of the end, `hit`
/// (1: something was hit there, 0: the ray only clears), `origin_x`, `origin_y` of the ray, and
/// `heading`, the gyro's integrated heading, the same for all rays; NaN where there is no gyro;
/// `speed_x`, `speed_y`, the integrated acceleration (PlanarScan::speed), NaN where there is none.
/// `stamp` is the recorded stamp of the scan, its name and reference time.
sensor_msgs::PointCloud2Ptr toPlanarScanMessage(const PlanarScan& scan, const std::string& frame,
                                                const ros::Time& stamp);

/// The inverse. Throws std::invalid_argument that names what is wrong: a missing field, a field of
/// another type, a payload shorter than promised, big-endian data.
PlanarScan fromPlanarScanMessage(const sensor_msgs::PointCloud2& message);

/// The hits as a LaserScan around the base, for packages that know nothing else: in every bin of
/// `angle_increment` (rad) the nearest hit, +inf where rays only clear, NaN where there is no ray.
sensor_msgs::LaserScanPtr toLaserScanView(const PlanarScan& scan, const std::string& frame,
                                          const ros::Time& stamp, double angle_increment,
                                          double range_max);

}  // namespace kestrel_slam
