// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/graph/loop_matcher.h"
#include "kestrel_slam/graph/places.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

class SubmapGraph;

/// What one vehicle has mapped, in the frame of its own map.
struct VehicleMap {
  std::string name;
  /// In the order of the flight, with their poses in the local frame of the mapper: those of one
  /// place never change.
  std::vector<LocalKeyframe> keyframes;
  std::vector<Pose2> poses;  ///< of the keyframes, in the vehicle's map, as its graph corrects them
  std::vector<KnownPlace> places;
  std::vector<PoseEdge> edges;       ///< odometry and accepted loops; vertices are the keyframes
  std::optional<Pose2> world_T_map;  ///< a guess of the user, as a known start pose
};

/// Unfinished submaps become places too, unless they have only a few keyframes.
VehicleMap vehicleMapOf(const std::string& name, const SubmapGraph& graph);

/// If the session has no graph, successive keyframes are joined by odometry. If it has no submaps,
/// the keyframes are cut into places.
VehicleMap vehicleMapOf(const std::string& name, const Session& session);

/// Why nothing can be merged with this map; "" if it can.
std::string problemOf(const VehicleMap& map);

/// All keyframes of the vehicle as queries, one after the other. A query ends where the odometry
/// between two keyframes is missing.
std::vector<LoopQuery> queriesOf(const VehicleMap& map, const LoopConfig& config);

}  // namespace kestrel
