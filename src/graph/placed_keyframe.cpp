// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/placed_keyframe.h"

#include <limits>
#include <map>
#include <tuple>

namespace kestrel {
namespace {

/// Identifies a keyframe in two sessions. Two vehicles may have scans of the same time.
using KeyframeName = std::tuple<double, double, double, double>;

KeyframeName nameOf(const Keyframe& keyframe) {
  const Pose2& pose = keyframe.submap_T_base;
  return {keyframe.stamp, pose.x, pose.y, pose.yaw};
}

}  // namespace

Submap submapOf(const std::vector<PlacedKeyframe>& keyframes, const OccupancyGridConfig& config) {
  // One number for all: the errors that the keyframes had to each other are not known any more.
  constexpr std::uint32_t kNumber = 0;
  Submap result(config);
  for (const PlacedKeyframe& placed : keyframes) {
    const Keyframe& keyframe = *placed.keyframe;
    result.insert(keyframe.planarScan(), placed.map_T_base, keyframe.new_view, kNumber);
  }
  return result;
}

std::optional<Pose2> mapMotionAt(const Pose2& map_T_base, const std::vector<PlacedKeyframe>& before,
                                 const std::vector<PlacedKeyframe>& after) {
  std::map<KeyframeName, Pose2> poses;
  for (const PlacedKeyframe& placed : after) poses[nameOf(*placed.keyframe)] = placed.map_T_base;
  std::optional<Pose2> result;
  double nearest = std::numeric_limits<double>::infinity();
  for (const PlacedKeyframe& placed : before) {
    const double distance = placed.map_T_base.between(map_T_base).distance();
    const auto found = poses.find(nameOf(*placed.keyframe));
    if (distance >= nearest || found == poses.end()) continue;
    nearest = distance;
    result = found->second * placed.map_T_base.inverse();
  }
  return result;
}

}  // namespace kestrel
