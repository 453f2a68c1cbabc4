// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// The vertices of a graph as the odometry alone places them, with the covariances of what lies
/// between any two of them in constant time. Odometry joins vertex i and vertex i + 1. Where
/// that edge is missing, a new part begins, whose pose relative to the others is unknown: another
/// vehicle, or the same one after it was carried away.
class OdometryChain {
 public:
  OdometryChain() = default;
  explicit OdometryChain(const PoseGraph& graph) { grow(graph); }

  /// Takes the vertices and odometry edges that were added to `graph` since the last call. An edge
  /// that leads to a vertex of an earlier call is ignored, as are loops.
  void grow(const PoseGraph& graph);

  std::size_t size() const { return poses_.size(); }

  /// The index of the part of a vertex.
  std::size_t partOf(std::size_t vertex) const { return parts_[vertex]; }

  /// The pose of a vertex in the first vertex of its part.
  const Pose2& pose(std::size_t vertex) const { return poses_[vertex]; }

  /// The odometry's noise between the vertices `from` < `to` of one part: the covariance of an
  /// error on the left of their poses, exp(t) pose. With the adjoint of any frame it becomes the
  /// covariance in that frame, and those of successive intervals add up.
  Eigen::Matrix3d noiseBetween(std::size_t from, std::size_t to) const {
    return noise_[to] - noise_[from];
  }

 private:
  std::vector<Pose2> poses_;
  std::vector<Eigen::Matrix3d> noise_;  // summed from the beginning of the part
  std::vector<std::size_t> parts_;
  std::size_t edges_ = 0;  // of the graph that were read
};

}  // namespace kestrel
