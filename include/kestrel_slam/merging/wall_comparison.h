// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/merging/joint_map.h"

namespace kestrel {

/// The longest straight wall in the map of one vehicle that stands where the other vehicle has seen
/// free space, m. In the same building this is a door that was closed, or a cupboard that was
/// moved; in another one it is a wall. Where the heights of the scans are known, walls are compared
/// at the heights at which they were seen: a lintel is no wall in its door. `poses`: of all
/// keyframes, in one frame. Only the surroundings of the `agreeing` keyframes are compared:
/// elsewhere, walls may differ because the maps have drifted.
double longestContradictingWall(const JointMap& joint, const std::vector<PoseVertex>& poses,
                                const std::vector<Loop>& agreeing, std::size_t a, std::size_t b);

}  // namespace kestrel
