// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/loop.h"
#include "kestrel_slam/graph/placed_keyframe.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/map/keyframe.h"
#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {

struct NamedNumber {
  std::string name;
  double value = 0.0;
};

/// A part of the map that moves as a whole.
struct SubmapRecord {
  std::uint64_t id = 0;
  Pose2 map_T_submap;
  bool finished = false;
  std::vector<std::uint64_t> keyframes;  ///< ids
};

enum class VertexKind { kKeyframe, kSubmap };

/// A vertex of the pose graph: the pose of a keyframe or of a submap.
struct VertexRecord {
  VertexKind kind = VertexKind::kKeyframe;
  std::uint64_t id = 0;  ///< of the keyframe or submap
  PoseVertex vertex;
};
/// A loop that was tried. If it is accepted, the graph has an edge for it, too.
struct LoopRecord {
  std::size_t from = 0, to = 0;  ///< indices of vertices
  GaussianPose2 measured;        ///< from_T_to
  LoopState state = LoopState::kPending;
  std::string reason;                 ///< why it has this state; may be empty
  std::vector<NamedNumber> measures;  ///< fit, margin and so on
};

/// The wheel odometry at a keyframe and at some scans before and after it.
struct OdometryRecord {
  std::uint64_t keyframe = 0;      ///< its id
  std::vector<Pose2> odom_T_base;  ///< in the order of time
  std::size_t own = 0;             ///< which of them is that of the scan of the keyframe
};

/// All that is kept of a flight. Grids are not: they are made from the keyframes again.
struct Session {
  std::string written_by;  ///< name and version of the program
  double resolution_m = 0.05;
  std::string parameters;  ///< YAML
  std::vector<NamedNumber> statistics;
  std::optional<Pose2> end;  ///< map_T_base where the flight ended
  std::vector<KeyframePtr> keyframes;
  std::vector<SubmapRecord> submaps;
  std::vector<VertexRecord> vertices;
  std::vector<PoseEdge> edges;
  std::vector<LoopRecord> loops;
  std::vector<OdometryRecord> odometry;  ///< in the order of the keyframes; may be empty
};

/// The first thing in a session that must not be, such as a pose that is not finite, an id that is
/// not unique or a submap that does not exist; "" if there is none. Only sessions without a problem
/// are saved, and loading gives no others.
std::string problemOf(const Session& session);

/// Removes everything that refers to something that is not there.
void removeDangling(Session& session);

/// Removes keyframes that are in no submap: what session_link brings before the submaps.
void removeUnplaced(Session& session);

/// map_T_base of every keyframe, in their order: the pose of its vertex in the graph. If it has
/// none, the pose that it has in the first submap that contains it.
std::vector<Pose2> keyframePoses(const Session& session);

/// The graph with the indices of `vertices`, without loops that were not accepted.
PoseGraph graphOf(const Session& session);

/// The keyframes of the map: those of the largest part of the graph, see connectedParts(). Where
/// the other parts lie in it, nobody knows. All of them, if the session has no edges.
std::vector<PlacedKeyframe> mapKeyframes(const Session& session);

/// Of how many parts mapKeyframes() takes the largest.
std::size_t partCount(const Session& session);

/// The map of mapKeyframes(), up to the memory limit of `config`.
MapSnapshot mapOf(const Session& session, const OccupancyGridConfig& config);

}  // namespace kestrel
