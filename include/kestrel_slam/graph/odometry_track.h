// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "kestrel_slam/graph/odometry_selection.h"
#include "kestrel_slam/graph/odometry_worth.h"
#include "kestrel_slam/graph/pose_graph.h"
#include "kestrel_slam/mapping/odometry_sign.h"

namespace kestrel {

/// The wheel odometry around a keyframe.
struct TrackedKeyframe {
  std::size_t number = 0;
  Pose2 local_T_base;
  std::vector<Pose2> odometry;  ///< at some scans before and after it
  std::size_t own = 0;          ///< which of them is that of its own scan
};

/// Where the optimized graph places a pose of the odometry.
struct PlacedOdometry {
  std::size_t keyframe = 0;
  Pose2 map_T_base;
};

/// The wheel odometry along the keyframes of a graph. Matches are more accurate over some meters;
/// a good odometry is more accurate over a long way. So both are in the graph: the odometry is a
/// second chain of vertices, and an edge joins each keyframe with its vertex of that chain. The
/// weights follow from what the odometry proved to be worth.
class OdometryTrack {
 public:
  OdometryTrack() = default;
  /// Goes on from a record.
  explicit OdometryTrack(std::vector<TrackedKeyframe> keyframes)
      : keyframes_(std::move(keyframes)), closed_(keyframes_.size()) {}

  /// The odometry at a scan, in the order of time. `is_reversed`: see MapperResult::reversed.
  void add(const std::optional<Pose2>& odom_T_base, bool is_reversed = false);
  /// The scan that was added last is this keyframe. `local_T_base`: as matched.
  void addKeyframe(std::size_t keyframe, const Pose2& local_T_base);

  bool empty() const { return keyframes_.empty(); }
  const std::vector<TrackedKeyframe>& keyframes() const { return keyframes_; }

  /// Compares the odometry with the matches again. `chain`: the matches, a vertex per keyframe.
  void learn(const OdometryChain& chain);
  const OdometryWorth& worth() const { return worth_; }
  /// So many scans later the odometry has the pose of a scan.
  int delayScans() const { return delay_scans_; }

  /// Adds the vertices and edges of the odometry. The edges have robust kernels, because wheels
  /// slip. Matches that may be wrong (`doubtful`, for each keyframe) lose their weight where the
  /// odometry refutes them (selectOdometry). The new vertices are in the order of the points that
  /// are returned.
  OdometrySelection addTo(PoseGraph& graph, const OdometryChain& chain,
                          const std::vector<bool>& doubtful) const;

  /// Remembers where the optimization has moved the points, which are the last vertices.
  void place(const OdometrySelection& selection, const PoseGraph& graph);
  const std::vector<PlacedOdometry>& placed() const { return placed_; }
  /// Of single poses, with the matches of keyframes.
  const Contradictions& singleContradictions() const { return single_; }

  std::size_t memoryBytes() const;

 private:
  std::vector<OdometryPoint> pointsAt(int delay_scans) const;
  PoseEdge edgeBetween(const OdometryPoint& a, const OdometryPoint& b, std::size_t to) const;

  std::vector<TrackedKeyframe> keyframes_;
  std::size_t closed_ = 0;  ///< those before this one are of earlier flights
  SignedOdometry signed_;
  std::vector<Pose2> recent_;
  int delay_scans_ = 0;
  OdometryWorth worth_;
  std::vector<PlacedOdometry> placed_;
  Contradictions single_;
};

}  // namespace kestrel
