// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/keyframe.h"
#include "kestrel_slam/map/submap.h"

namespace kestrel {

/// A keyframe and its pose in map.
struct PlacedKeyframe {
  KeyframePtr keyframe;
  Pose2 map_T_base;
};

/// The map of these keyframes, to localize in.
Submap submapOf(const std::vector<PlacedKeyframe>& keyframes, const OccupancyGridConfig& config);

/// How the map has moved (after_T_before) where `map_T_base` is in the map before: as the nearest
/// keyframe that is in both maps. After a join a vehicle has another frame than before. Nothing if
/// they have no keyframe in common.
std::optional<Pose2> mapMotionAt(const Pose2& map_T_base, const std::vector<PlacedKeyframe>& before,
                                 const std::vector<PlacedKeyframe>& after);

}  // namespace kestrel
