// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kestrel_slam/lidar/ground.h"
#include "kestrel_slam/tracking/cell_map.h"

namespace kestrel {

/// The visitation grid [Siew 2018, sec. V]: it finds the cells that beams without return have
/// passed, for clouds that do not tell the directions of these beams.
struct VisitationConfig {
  double resolution_m = 0.5;
  /// Angle between two rings, rad. The radius of the grid is so small that a beam passes every
  /// cell.
  double ring_step_rad = 0.0232;  ///< HDL-32E: 1.33 degrees
  double max_radius_m = 20.0;     ///< bounds the work for lidars with narrow rings
};

/// The cells, in the frame of the map, inside the sector that the lidar sees and above the ground,
/// through which no beam goes that gave a return. `points`: in the frame of the lidar.
std::vector<GridIndex<3>> unvisitedCells(const std::vector<Eigen::Vector3f>& points,
                                         const Ground& ground, const Eigen::Isometry3d& map_T_lidar,
                                         const VisitationConfig& config);

}  // namespace kestrel
