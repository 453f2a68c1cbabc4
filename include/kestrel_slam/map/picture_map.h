// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/map/submap.h"

namespace kestrel {

/// A map to localize in from a picture of any program: walls are the occupied cells that border on
/// others, at their centers. The size of the cells is that of the picture.
Submap submapOf(const MapSnapshot& picture, OccupancyGridConfig config);

}  // namespace kestrel
