// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/merged_session.h"

#include <memory>

namespace kestrel {
namespace {

/// The same when maps have grown: session_link recognizes a keyframe by its id.
std::uint64_t idOf(const std::string& vehicle, const Keyframe& keyframe) {
  KeyMaker key;
  key.add(vehicle);
  key.add(keyframe.id);
  key.add(keyframe.stamp);
  key.add(keyframe.scan.bytes());
  return key.key().front();
}

/// Adds the keyframes, submaps and vertices of one vehicle.
void addVehicle(const VehicleMap& vehicle, const std::vector<Pose2>& poses, Session& session) {
  const std::uint64_t first = session.keyframes.size();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    auto keyframe = std::make_shared<Keyframe>(*vehicle.keyframes[i].keyframe);
    keyframe->id = idOf(vehicle.name, *keyframe);
    keyframe->submap_T_base = vehicle.keyframes[i].local_T_base;
    session.vertices.push_back({VertexKind::kKeyframe, keyframe->id, {poses[i], i + first == 0}});
    session.keyframes.push_back(std::move(keyframe));
  }
  for (const KnownPlace& place : vehicle.places) {
    const Pose2 local_T_base = vehicle.keyframes[place.first].local_T_base;
    SubmapRecord submap{
        session.submaps.size(), poses[place.first] * local_T_base.inverse(), true, {}};
    for (std::size_t i = place.first; i < place.last; ++i)
      submap.keyframes.push_back(session.keyframes[first + i]->id);
    session.submaps.push_back(std::move(submap));
  }
}

}  // namespace

Session mergedSession(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                      std::size_t vehicle) {
  Session session;
  std::vector<std::size_t> new_index;  // of the vertices of the joint graph
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    const bool in_group = merged.group[v] == merged.group[vehicle];
    for (std::size_t i = 0; i < vehicles[v].keyframes.size(); ++i)
      new_index.push_back(in_group ? session.keyframes.size() + i : kNone);
    if (in_group) addVehicle(vehicles[v], merged.poses[v], session);
  }
  for (PoseEdge edge : merged.graph.edges) {
    edge.from = new_index[edge.from];
    edge.to = new_index[edge.to];
    if (edge.from != kNone && edge.to != kNone) session.edges.push_back(edge);
  }
  return session;
}

MapSnapshot mapOf(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                  std::size_t vehicle, const OccupancyGridConfig& config) {
  OccupancyGrid grid(config);
  for (std::size_t v = 0; v < vehicles.size(); ++v) {
    if (merged.group[v] != merged.group[vehicle]) continue;
    for (std::size_t i = 0; i < vehicles[v].keyframes.size(); ++i) {
      const Keyframe& keyframe = *vehicles[v].keyframes[i].keyframe;
      grid.insert(keyframe.planarScan(), merged.poses[v][i], keyframe.new_view);
    }
  }
  return grid.snapshot();
}

std::string problemOf(const std::vector<VehicleMap>& vehicles) {
  for (std::size_t b = 0; b < vehicles.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const VehicleMap &first = vehicles[a], &second = vehicles[b];
      if (first.name == second.name)
        return "two vehicles are called " + first.name + "; give one of them another name";
      if (first.keyframes.empty() || second.keyframes.empty()) continue;
      const Keyframe &x = *first.keyframes.front().keyframe,
                     &y = *second.keyframes.front().keyframe;
      if (x.stamp == y.stamp && x.scan == y.scan)
        return first.name + " and " + second.name + " are the same flight; give it once";
    }
  }
  return "";
}

}  // namespace kestrel
