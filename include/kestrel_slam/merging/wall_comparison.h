// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/merging/joint_map.h"

namespace kestrel {

/// The longest straight wall in the map of one vehicle that stands where the other vehicle has seen
/// free space, m. In the same building this is a door that was closed, or a cupboard that was
/// moved; in another one it is a wall. `poses`: of all keyframes, in one frame.
double longestContradictingWall(const JointMap& joint, const std::vector<PoseVertex>& poses,
                                std::size_t a, std::size_t b);

}  // namespace kestrel
