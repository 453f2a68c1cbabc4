// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/session.h"

#include <set>
#include <unordered_map>

namespace kestrel {
namespace {

/// The part of the graph of each keyframe: that of its vertex, or else that of its submap's. Those
/// with neither are one part.
std::vector<std::size_t> keyframeParts(const Session& session) {
  std::vector<std::size_t> result(session.keyframes.size(), session.vertices.size());
  if (session.edges.empty()) return result;
  const std::vector<std::size_t> parts = connectedParts(graphOf(session));
  std::unordered_map<std::uint64_t, std::size_t> of_keyframe, of_submap;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const VertexRecord& vertex = session.vertices[i];
    (vertex.kind == VertexKind::kKeyframe ? of_keyframe : of_submap).emplace(vertex.id, parts[i]);
  }
  for (const SubmapRecord& submap : session.submaps) {
    const auto part = of_submap.find(submap.id);
    if (part == of_submap.end()) continue;
    for (const std::uint64_t id : submap.keyframes) of_keyframe.emplace(id, part->second);
  }
  for (std::size_t i = 0; i < result.size(); ++i) {
    const auto part = of_keyframe.find(session.keyframes[i]->id);
    if (part != of_keyframe.end()) result[i] = part->second;
  }
  return result;
}

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

std::vector<PlacedKeyframe> mapKeyframes(const Session& session) {
  const std::vector<Pose2> poses = keyframePoses(session);
  const std::vector<std::size_t> parts = keyframeParts(session);
  const std::size_t largest = largestPart(parts);
  std::vector<PlacedKeyframe> result;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (parts[i] == largest) result.push_back({session.keyframes[i], poses[i]});
  return result;
}

std::size_t partCount(const Session& session) {
  const std::vector<std::size_t> parts = keyframeParts(session);
  return std::set<std::size_t>(parts.begin(), parts.end()).size();
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
  for (const PlacedKeyframe& placed : mapKeyframes(session)) {
    const Keyframe& keyframe = *placed.keyframe;
    grid.insert(keyframe.planarScan(), placed.map_T_base, keyframe.new_view);
  }
  return grid.snapshot();
}

}  // namespace kestrel
