// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/vehicle_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <unordered_map>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

/// A place with fewer keyframes shows too little.
constexpr std::size_t kLeastKeyframes = 20;
/// Size of a place, and what it has in common with the next one, where a session has no submaps.
constexpr std::size_t kPlaceKeyframes = 90, kOverlap = 30;
/// A map with a smaller area around its path, or with fewer hits, cannot be told from others.
constexpr std::size_t kLeastHits = 1000;
/// Errors of the motion between two keyframes of a session without a graph.
constexpr double kMotionM = 0.01, kMotionRad = 0.005;

/// For every keyframe, whether the mapper has lost its way before it: a new local frame begins.
std::vector<bool> breaksOf(const VehicleMap& map) {
  std::vector<bool> breaks(map.keyframes.size(), true);
  for (const PoseEdge& edge : map.edges) {
    if (edge.kind == EdgeKind::kOdometry && edge.to == edge.from + 1) breaks[edge.to] = false;
  }
  return breaks;
}

bool hasBreak(const std::vector<bool>& breaks, std::size_t first, std::size_t last) {
  for (std::size_t i = first + 1; i < last; ++i)
    if (breaks[i]) return true;
  return false;
}

void addPlace(VehicleMap& map, std::size_t first, std::size_t last) {
  const bool is_small = last < first + kLeastKeyframes && !map.places.empty();
  if (is_small && !hasBreak(breaksOf(map), map.places.back().first, last)) {
    map.places.back().last = last;
  } else {
    map.places.push_back({static_cast<std::uint32_t>(map.places.size()), first, last});
  }
}

/// Places for the keyframes from `first` on.
void cutIntoPlaces(VehicleMap& map, std::size_t first) {
  const std::vector<bool> breaks = breaksOf(map);
  std::size_t part = first;  // its first keyframe
  for (std::size_t begin = first; begin < map.keyframes.size();) {
    std::size_t end = begin + 1;
    while (end < map.keyframes.size() && end < begin + kPlaceKeyframes && !breaks[end]) ++end;
    if (breaks[begin]) part = begin;
    addPlace(map, begin - std::min(begin - part, kOverlap), end);
    begin = end;
  }
}

/// Keyframes of a session by their ids.
std::unordered_map<std::uint64_t, std::size_t> numbersOf(const Session& session) {
  std::unordered_map<std::uint64_t, std::size_t> numbers;
  for (std::size_t i = 0; i < session.keyframes.size(); ++i)
    numbers.emplace(session.keyframes[i]->id, i);
  return numbers;
}

void addSubmaps(const Session& session, VehicleMap& map) {
  const auto numbers = numbersOf(session);
  for (const SubmapRecord& submap : session.submaps) {
    std::size_t first = map.keyframes.size(), last = 0;
    for (const std::uint64_t id : submap.keyframes) {
      const std::size_t number = numbers.at(id);
      first = std::min(first, number);
      last = std::max(last, number + 1);
    }
    // A submap that has grown over the whole flight is cut.
    if (last > first && last - first <= 2 * kPlaceKeyframes) addPlace(map, first, last);
  }
}

void addEdges(const Session& session, VehicleMap& map) {
  const auto numbers = numbersOf(session);
  const std::size_t none = session.keyframes.size();
  std::vector<std::size_t> keyframe_of;
  for (const VertexRecord& vertex : session.vertices)
    keyframe_of.push_back(vertex.kind == VertexKind::kKeyframe ? numbers.at(vertex.id) : none);
  for (PoseEdge edge : session.edges) {
    edge.from = keyframe_of[edge.from];
    edge.to = keyframe_of[edge.to];
    if (edge.from != none && edge.to != none) map.edges.push_back(edge);
  }
}

void addMotions(VehicleMap& map) {
  for (std::size_t i = 1; i < map.keyframes.size(); ++i) {
    Eigen::Matrix3d covariance = map.keyframes[i].keyframe->motion_covariance;
    covariance.diagonal() += Eigen::Vector3d(kMotionM, kMotionM, kMotionRad).cwiseAbs2();
    const Pose2 motion = map.poses[i - 1].between(map.poses[i]);
    map.edges.push_back({i - 1, i, motion, covariance.inverse(), EdgeKind::kOdometry});
  }
}

}  // namespace

VehicleMap vehicleMapOf(const std::string& name, const SubmapGraph& graph) {
  VehicleMap map;
  map.name = name;
  map.keyframes = graph.keyframes();
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) map.poses.push_back(graph.poseOf(i));
  map.edges = graph.graph().edges;
  map.places = graph.places().all();
  const std::size_t finished = map.places.empty() ? 0 : map.places.back().last;
  if (finished < map.keyframes.size()) {
    addPlace(map, finished - std::min(finished, kOverlap), map.keyframes.size());
  }
  return map;
}

VehicleMap vehicleMapOf(const std::string& name, const Session& session) {
  VehicleMap map;
  map.name = name;
  map.poses = keyframePoses(session);
  addEdges(session, map);
  // Without submaps nobody knows what the keyframe's own pose refers to.
  const bool has_local = !session.submaps.empty() && !map.edges.empty();
  for (std::size_t i = 0; i < map.poses.size(); ++i) {
    const KeyframePtr& keyframe = session.keyframes[i];
    map.keyframes.push_back({keyframe, 0, has_local ? keyframe->submap_T_base : map.poses[i]});
  }
  if (map.edges.empty()) addMotions(map);
  addSubmaps(session, map);
  std::size_t covered = 0;
  for (const KnownPlace& place : map.places) covered = std::max(covered, place.last);
  cutIntoPlaces(map, covered);
  return map;
}

std::string problemOf(const VehicleMap& map) {
  if (map.keyframes.size() < kLeastKeyframes) {
    return "it has only " + std::to_string(map.keyframes.size()) + " keyframes of at least " +
           std::to_string(kLeastKeyframes);
  }
  std::size_t hits = 0;
  for (const LocalKeyframe& keyframe : map.keyframes) hits += keyframe.keyframe->scan.hitCount();
  if (hits < kLeastHits) return "its scans have only " + std::to_string(hits) + " hits";
  return "";
}

std::vector<LoopQuery> queriesOf(const VehicleMap& map, const LoopConfig& config) {
  const auto most = static_cast<std::size_t>(config.query_keyframes);
  const std::vector<bool> breaks = breaksOf(map);
  std::vector<LoopQuery> queries;
  LoopQuery query;
  double path = 0.0;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    if (breaks[i]) query.first = i, path = 0.0;
    if (i > query.first)
      path += map.keyframes[i - 1].local_T_base.between(map.keyframes[i].local_T_base).distance();
    query.last = i + 1;
    const std::size_t count = query.last - query.first;
    if (count < most && (2 * count < most || path < config.query_path_m)) continue;
    queries.push_back(query);
    query.first = query.last;
    path = 0.0;
  }
  return queries;
}

}  // namespace kestrel
