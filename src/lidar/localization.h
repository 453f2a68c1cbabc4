// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/lidar/surface_map.h"

namespace kestrel {

/// How far a lidar may be from its predicted place after this time, m.
double searchRadius(double seconds, bool is_motion_known);

/// The pose of a sweep in the map. Nothing if no pose within `radius` (m) of the guess fits: then
/// the sweep must not enter the map.
std::optional<Eigen::Isometry3d> findSweep(const std::vector<Eigen::Vector3f>& points,
                                           const SurfaceMap& map, const CloudTrackerConfig& config,
                                           const Eigen::Isometry3d& guess, double radius);

}  // namespace kestrel
