// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/simulation/laser_model.h"
#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// Simulates one sweep that starts at `time` (s). Each beam is cast from the sensor's pose at the
/// time of that beam. The `stamp` of the result is `time`. The result depends only on the arguments
/// and the state of `random`.
LaserScan sweep(const LaserModel& laser, const World& world, const Motion& motion,
                const Eigen::Isometry3d& base_T_laser, double time, Random& random);
PointCloud sweep(const LidarModel& lidar, const World& world, const Motion& motion,
                 const Eigen::Isometry3d& base_T_lidar, double time, Random& random);

}  // namespace kestrel
