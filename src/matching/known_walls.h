// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// The points (base frame, m) without the first looks at something new. Such a hit is in unknown
/// space, and past the end of the nearest wall, not before or behind it. If it counted, it would
/// draw the pose to that wall: a vehicle that flies backward sees more of the walls beside it with
/// every scan, and would stand still in its map.
/// `scan_size`: number of points of the scan, of which `points` may be a part.
Points hitsOfKnownWalls(const Submap& map, const Points& points, const Pose2& map_T_base,
                        std::size_t scan_size);

}  // namespace kestrel
