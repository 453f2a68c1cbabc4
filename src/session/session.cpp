// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/session.h"

#include <unordered_map>

namespace kestrel {
namespace {

/// For every keyframe in a submap, its pose in map by the first submap that contains it.
std::unordered_map<std::uint64_t, Pose2> submapPoses(const Session& session) {
  std::unordered_map<std::uint64_t, Pose2> map_T_submap;
  for (const SubmapRecord& submap : session.submaps) {
    for (const std::uint64_t id : submap.keyframes) map_T_submap.emplace(id, submap.map_T_submap);
  }
  return map_T_submap;
}

}  // namespace

std::vector<Pose2> keyframePoses(const Session& session) {
  const std::unordered_map<std::uint64_t, Pose2> map_T_submap = submapPoses(session);
  std::unordered_map<std::uint64_t, Pose2> in_graph;
  for (const VertexRecord& vertex : session.vertices) {
    if (vertex.kind == VertexKind::kKeyframe) in_graph.emplace(vertex.id, vertex.vertex.pose);
  }
  std::vector<Pose2> poses;
  poses.reserve(session.keyframes.size());
  for (const KeyframePtr& keyframe : session.keyframes) {
    const auto found = in_graph.find(keyframe->id);
    poses.push_back(found != in_graph.end()
                        ? found->second
                        : map_T_submap.at(keyframe->id) * keyframe->submap_T_base);
  }
  return poses;
}

PoseGraph graphOf(const Session& session) {
  PoseGraph graph;
  graph.vertices.reserve(session.vertices.size());
  for (const VertexRecord& vertex : session.vertices) graph.vertices.push_back(vertex.vertex);
  graph.edges = session.edges;
  return graph;
}

MapSnapshot mapOf(const Session& session, const OccupancyGridConfig& config) {
  OccupancyGrid grid(config);
  const std::vector<Pose2> poses = keyframePoses(session);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Keyframe& keyframe = *session.keyframes[i];
    grid.insert(keyframe.planarScan(), poses[i], keyframe.new_view);
  }
  return grid.snapshot();
}

}  // namespace kestrel
