// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/graph/keyframe_errors.h"
#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/graph/scan_poses.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

class SubmapGraph;
struct OccupancyGridConfig;

/// The pose graph at the end of a run.
struct GraphResult {
  PoseGraph graph;             ///< its vertices are the keyframes
  std::vector<double> stamps;  ///< of the keyframes, s
  std::vector<KeyframeErrors> errors;
  std::vector<Loop> loops;  ///< all that were tried
  std::size_t submaps = 0;  ///< finished ones
  std::size_t memory_bytes = 0;
  Trajectory before;  ///< as mapped, without the corrections

  /// Number of loops by state and reason: "accepted", "refused: it does not fit".
  std::map<std::string, std::size_t> counts() const;
};

/// The poses of the scans in map, see scanPoses().
Trajectory corrected(const Trajectory& trajectory, const std::vector<TrackedScan>& scans,
                     const SubmapGraph& graph);

/// The map of all keyframes at their corrected poses.
MapSnapshot mapOf(const SubmapGraph& graph, const OccupancyGridConfig& config);

/// What to tell the user about parts of the graph that no loop has joined.
std::vector<std::string> partWarnings(const SubmapGraph& graph);

GraphResult resultOf(const SubmapGraph& graph, const Trajectory& before);

/// All loops as a table with the columns query, anchor (stamps), state, reason, fit, known,
/// constraint, margin, agreement, radius, correction.
std::string loopsText(const GraphResult& result);

}  // namespace kestrel
