// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/map/occupancy_grid_config.h"

namespace kestrel {

/// Leaves out the keyframes from `first` on that show nothing new: the map of the keyframes before
/// `first` has nearly all that they see, and they see nearly all that it has there. So a map does
/// not grow where it is known, and follows what has changed. People who walk by do not count: the
/// other new keyframes show that the place is free.
///
/// The odometry past the removed keyframes is kept, and so is the best of their loops on each
/// keyframe that is left. Keyframes that no loop joins with those before `first` stay.
GraphRecord withoutRepeated(GraphRecord record, std::size_t first,
                            const OccupancyGridConfig& config);

}  // namespace kestrel
