// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {

/// The direction of the wall at hit `i` from its neighbors in the scan, as (cos, sin) of twice its
/// angle, or zero where they make no line. `sparse`: they are so far apart that a match had better
/// not trust it.
Eigen::Vector2f tangentAt(const std::vector<OccupancyGrid::Changes::Hit>& hits, std::size_t i,
                          bool& sparse);

}  // namespace kestrel
