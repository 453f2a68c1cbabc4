// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// The stamp becomes that of the message (with the resolution of a double). The caller sets the
/// frame.
sensor_msgs::LaserScan toScanMessage(const LaserScan& scan);
/// The points with x, y, z and time (s after the stamp, float32).
sensor_msgs::PointCloud2 toCloudMessage(const PointCloud& cloud);

}  // namespace kestrel
