// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

struct PoseVertex {
  Pose2 pose;          ///< map_T_vertex
  bool fixed = false;  ///< the optimizer does not move it
};

/// Only loops get a robust kernel: odometry is never wrong by a mistaken place.
enum class EdgeKind { kOdometry, kLoop };

/// A measured pose of one vertex relative to another.
struct PoseEdge {
  std::size_t from = 0, to = 0;  ///< indices of vertices
  Pose2 measured;                ///< from_T_to
  /// Inverse covariance (1/m², 1/(m rad), 1/rad²; order x, y, yaw) of the error in the tangent
  /// space of `measured`: x and y are along the axes of `to`. This is the inverse of
  /// GaussianPose2::covariance, and the information matrix of EDGE_SE2 in g2o files
  /// [Kümmerle 2011]. It must be positive definite; an unobservable direction gets a small value.
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
  EdgeKind kind = EdgeKind::kOdometry;
};

struct PoseGraph {
  std::vector<PoseVertex> vertices;
  std::vector<PoseEdge> edges;
};

/// What is wrong with an edge of a graph with `vertices` vertices; "" if nothing is.
std::string problemOf(const PoseEdge& edge, std::size_t vertices);

/// The first problem of the graph, with the index of its edge or vertex; "" if there is none.
std::string problemOf(const PoseGraph& graph);

/// For every vertex, whether the optimizer holds it: all that are fixed, and the first one of each
/// connected part of the graph that has no fixed vertex. Without it, that part could move as a
/// whole.
std::vector<bool> heldVertices(const PoseGraph& graph);

/// For every vertex, the lowest index of a vertex that is connected to it by edges. Two vertices
/// are connected if and only if they have the same one.
std::vector<std::size_t> connectedParts(const PoseGraph& graph);

/// The part with most of the vertices from `first` on, and of equal ones the first.
std::size_t largestPart(const std::vector<std::size_t>& parts, std::size_t first = 0);

/// The components (x, y, yaw) of measured⁻¹ from_T_to, m and rad, the yaw in (-pi, pi]: the error
/// of g2o's EDGE_SE2. `from` and `to` are the poses of the vertices in map. The Jacobians are by
/// the components of these poses in the axes of map (addOffset).
Eigen::Vector3d edgeError(const Pose2& measured, const Pose2& from, const Pose2& to,
                          Eigen::Matrix3d* J_error_from = nullptr,
                          Eigen::Matrix3d* J_error_to = nullptr);

/// error' information error, with three degrees of freedom.
double chi2Of(const PoseEdge& edge, const Pose2& from, const Pose2& to);

/// The same with the poses that the vertices have.
double chi2Of(const PoseEdge& edge, const PoseGraph& graph);

}  // namespace kestrel
