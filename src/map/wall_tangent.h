// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {

/// Direction of the wall at hit `i` from its neighbors in the scan, as (cos, sin) of twice its
/// angle; zero if the neighbors are not on a line. `sparse` is set if the neighbors are too far
/// apart for the direction to be reliable.
Eigen::Vector2f tangentAt(const std::vector<OccupancyGrid::Changes::Hit>& hits, std::size_t i,
                          bool& sparse);

}  // namespace kestrel
