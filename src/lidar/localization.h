// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/lidar/ground.h"
#include "kestrel_slam/lidar/surface_map.h"

namespace kestrel {

/// How far a lidar may be from its predicted place after this time, m.
double searchRadius(double seconds, bool is_motion_known);

/// Where a sweep was taken.
struct SweepPlace {
  Eigen::Isometry3d pose;  ///< map_T_lidar; the guess if it was not found
  bool found = false;
  bool contradicted = false;  ///< surfaces show that it is not there: it must not enter the map
};

/// Seeks the sweep within `radius` (m) of the guess.
SweepPlace findSweep(const std::vector<Eigen::Vector3f>& points, const Ground& ground,
                     const SurfaceMap& map, const CloudTrackerConfig& config,
                     const Eigen::Isometry3d& guess, double radius);

}  // namespace kestrel
