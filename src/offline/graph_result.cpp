// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/graph_result.h"

#include <cstdio>

#include "kestrel_slam/graph/composed_map.h"
#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {

std::map<std::string, std::size_t> GraphResult::counts() const {
  std::map<std::string, std::size_t> result;
  for (const Loop& loop : loops) {
    ++result[toString(loop.state) + (loop.reason.empty() ? "" : ": " + loop.reason)];
  }
  return result;
}

Trajectory corrected(const Trajectory& trajectory, const std::vector<TrackedScan>& scans,
                     const SubmapGraph& graph) {
  Trajectory result = trajectory;
  const std::vector<Pose2> poses = scanPoses(scans, graph);
  for (std::size_t i = 0; i < poses.size(); ++i) result[i].pose = poses[i];
  return result;
}

MapSnapshot mapOf(const SubmapGraph& graph, const OccupancyGridConfig& config) {
  ComposedMap map(config);
  map.add(graph);
  return map.grid().snapshot();
}

GraphResult resultOf(const SubmapGraph& graph, const Trajectory& before) {
  GraphResult result;
  result.graph = graph.graph();
  for (const LocalKeyframe& keyframe : graph.keyframes())
    result.stamps.push_back(keyframe.keyframe->stamp);
  result.errors = graph.errors();
  result.loops = graph.loops();
  result.submaps = graph.submapCount();
  result.memory_bytes = graph.memoryBytes();
  result.before = before;
  return result;
}

std::vector<std::string> partWarnings(const SubmapGraph& graph) {
  std::vector<std::string> warnings;
  if (graph.keyframes().empty()) return warnings;
  if (graph.partCount() > 1)
    warnings.push_back(
        std::to_string(graph.partCount() - 1) +
        " part(s) of the recording could not be placed in the map: the vehicle was lost before, "
        "and saw nothing there that it knew; the map shows the largest part");
  if (graph.loadedCount() > 0 && !graph.isJoined(0))
    warnings.emplace_back(
        "the flight was not found in the map of the session: map and trajectory show the new part "
        "only, and the session keeps both apart; --start says where it begins");
  return warnings;
}

std::string loopsText(const GraphResult& result) {
  std::string text =
      "query,anchor,x,y,yaw,state,reason,fit,known,constraint,margin,agreement,radius,"
      "correction\n";
  for (const Loop& loop : result.loops) {
    const Pose2& pose = loop.anchor_T_query.mean;
    char line[256];
    std::snprintf(line, sizeof line,
                  "%.6f,%.6f,%.4f,%.4f,%.5f,%s,%s,%.3f,%.3f,%.4f,%.3f,%.2f,%.2f,%.3f\n",
                  result.stamps[loop.query], result.stamps[loop.anchor], pose.x, pose.y, pose.yaw,
                  toString(loop.state), loop.reason.c_str(), loop.fit, loop.known, loop.constraint,
                  loop.margin, loop.agreement, loop.radius_m, loop.correction_m);
    text += line;
  }
  return text;
}

}  // namespace kestrel
