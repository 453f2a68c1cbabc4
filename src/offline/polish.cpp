// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/polish.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// A scan is only moved a little: the map was made of it. One that fits worse is not used.
constexpr double kMostM = 0.1, kMostRad = 0.03, kLeastFit = 0.75, kLeastKnown = 0.7;
constexpr std::size_t kPoints = 1000, kLeastHits = 30;

Submap finishedMap(const SubmapGraph& graph, const MapperConfig& mapper) {
  Submap map(mapper.matchedGrid(), submapOptions(mapper.matcher));
  for (std::size_t i = 0; i < graph.keyframes().size(); ++i) {
    const Keyframe& keyframe = *graph.keyframes()[i].keyframe;
    if (graph.isJoined(i)) map.insert(keyframe.planarScan(), graph.poseOf(i), keyframe.new_view);
  }
  return map;
}

/// The pose where the scan fits; nothing if it does not fit near `guess`.
std::optional<Pose2> matched(const Submap& map, const CompactScan& scan, const Pose2& guess,
                             const MatcherConfig& config) {
  const Points points = sampled(scan.hits(), kPoints);
  if (points.size() < kLeastHits) return std::nullopt;
  const MatchResult match = matchNear(map, points, guess, config);
  if (match.score < kLeastFit || match.known < kLeastKnown) return std::nullopt;
  if (match.constraint < config.degenerate_share) return std::nullopt;
  const Pose2 moved = guess.between(match.pose);
  if (moved.distance() > kMostM || std::abs(moved.yaw) > kMostRad) return std::nullopt;
  return match.pose;
}

}  // namespace

Trajectory Polish::polished(const Trajectory& trajectory, const SubmapGraph& graph) {
  const Submap map = finishedMap(graph, mapper_);
  Trajectory result = trajectory;
  matched_ = 0;
  for (std::size_t i = 0; i < std::min(result.size(), scans_.size()); ++i) {
    const std::optional<Pose2> pose = matched(map, scans_[i], result[i].pose, mapper_.matcher);
    if (!pose) continue;
    result[i].pose = *pose;
    ++matched_;
  }
  return result;
}

MapSnapshot mapAlong(const Trajectory& trajectory, const SubmapGraph& graph,
                     const OccupancyGridConfig& config) {
  OccupancyGrid grid(config);
  std::size_t at = 0;
  for (std::size_t i = 0; i < graph.keyframes().size(); ++i) {
    const Keyframe& keyframe = *graph.keyframes()[i].keyframe;
    if (!graph.isJoined(i)) continue;
    std::size_t next = at;
    while (next < trajectory.size() && trajectory[next].stamp != keyframe.stamp) ++next;
    const bool found = i >= graph.loadedCount() && next < trajectory.size();
    if (found) at = next;
    grid.insert(keyframe.planarScan(), found ? trajectory[at].pose : graph.poseOf(i),
                keyframe.new_view);
  }
  return grid.snapshot();
}

}  // namespace kestrel
