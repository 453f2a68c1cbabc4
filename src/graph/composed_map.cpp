// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/composed_map.h"

#include <cmath>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// A smaller turn of a keyframe moves what it sees by less than a cell.
constexpr double kVisibleRad = 0.005;

}  // namespace

bool ComposedMap::isOutdated(const SubmapGraph& graph) const {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (shown_[i] != graph.isJoined(i)) return true;
    if (!shown_[i]) continue;
    const Pose2 moved = poses_[i].between(graph.poseOf(i));
    if (moved.distance() > 0.5 * config_.resolution_m || std::abs(moved.yaw) > kVisibleRad)
      return true;
  }
  return false;
}

void ComposedMap::add(const SubmapGraph& graph) {
  for (std::size_t i = poses_.size(); i < graph.keyframes().size(); ++i) {
    const Keyframe& keyframe = *graph.keyframes()[i].keyframe;
    poses_.push_back(graph.poseOf(i));
    shown_.push_back(graph.isJoined(i));
    if (shown_[i]) grid_.insert(keyframe.planarScan(), graph.poseOf(i), keyframe.new_view);
  }
}

}  // namespace kestrel
