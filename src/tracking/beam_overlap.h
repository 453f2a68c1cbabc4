// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/tracking/motion_grid.h"

namespace kestrel {

/// For each ray, the share of its way on which other rays pass its cells, too: near the sensor, the
/// beams of a scan are much denser than the cells. Rays in the order of the scan.
///
/// A ray that has one ray on each side, both not farther from it than half a cell, needs no own
/// passage there: at least one of both is in the same cell, but for the corners of cells. The rays
/// beside it are those with a number that is divisible by a larger power of two. The last cell of a
/// ray with a return is occupied, and nothing passes it.
std::vector<float> sharedWays(const std::vector<GridRay<2>>& rays, float cell);

}  // namespace kestrel
