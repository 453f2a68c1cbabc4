// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/pose_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <numeric>

namespace kestrel {
namespace {

bool isPositiveDefinite(const Eigen::Matrix3d& matrix) {
  return matrix.allFinite() && matrix.isApprox(matrix.transpose()) &&
         matrix.llt().info() == Eigen::Success;
}

/// The root of the tree of `vertex`; it shortens the way for the next call.
std::size_t rootOf(std::size_t vertex, std::vector<std::size_t>& parents) {
  while (parents[vertex] != vertex) {
    parents[vertex] = parents[parents[vertex]];
    vertex = parents[vertex];
  }
  return vertex;
}

}  // namespace

std::string problemOf(const PoseEdge& edge, std::size_t vertices) {
  if (edge.from >= vertices || edge.to >= vertices) return "one of its vertices does not exist";
  if (edge.from == edge.to) return "it leads from a vertex to the same vertex";
  if (!edge.measured.isFinite()) return "the measured pose is not finite";
  if (!isPositiveDefinite(edge.information)) {
    return "the information matrix is not symmetric and positive definite";
  }
  return "";
}

std::string problemOf(const PoseGraph& graph) {
  for (std::size_t i = 0; i < graph.vertices.size(); ++i) {
    if (!graph.vertices[i].pose.isFinite()) {
      return "vertex " + std::to_string(i) + ": the pose is not finite";
    }
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const std::string problem = problemOf(graph.edges[i], graph.vertices.size());
    if (!problem.empty()) return "edge " + std::to_string(i) + ": " + problem;
  }
  return "";
}

std::vector<std::size_t> connectedParts(const PoseGraph& graph) {
  std::vector<std::size_t> parents(graph.vertices.size());
  std::iota(parents.begin(), parents.end(), 0U);
  for (const PoseEdge& edge : graph.edges) {
    const std::size_t a = rootOf(edge.from, parents), b = rootOf(edge.to, parents);
    parents[std::max(a, b)] = std::min(a, b);
  }
  for (std::size_t i = 0; i < parents.size(); ++i) parents[i] = rootOf(i, parents);
  return parents;
}

std::size_t largestPart(const std::vector<std::size_t>& parts, std::size_t first) {
  std::map<std::size_t, std::size_t> counts;
  for (std::size_t i = first; i < parts.size(); ++i) ++counts[parts[i]];
  const auto largest =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return largest == counts.end() ? 0 : largest->first;
}

std::vector<bool> heldVertices(const PoseGraph& graph) {
  const std::vector<std::size_t> parts = connectedParts(graph);
  std::vector<bool> held(parts.size()), part_is_held(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    held[i] = graph.vertices[i].fixed;
    if (held[i]) part_is_held[parts[i]] = true;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] == i && !part_is_held[i]) held[i] = true;
  }
  return held;
}

Eigen::Vector3d edgeError(const Pose2& measured, const Pose2& from, const Pose2& to,
                          Eigen::Matrix3d* J_error_from, Eigen::Matrix3d* J_error_to) {
  const Pose2 error = measured.inverse() * (from.inverse() * to);
  const Eigen::Matrix2d r = Pose2(0.0, 0.0, -from.yaw - measured.yaw).rotation();
  if (J_error_to != nullptr) {
    J_error_to->setIdentity();
    J_error_to->topLeftCorner<2, 2>() = r;
  }
  if (J_error_from != nullptr) {
    J_error_from->setZero();
    J_error_from->topLeftCorner<2, 2>() = -r;
    J_error_from->topRightCorner<2, 1>() = r * Eigen::Vector2d(to.y - from.y, from.x - to.x);
    (*J_error_from)(2, 2) = -1.0;
  }
  return {error.x, error.y, error.yaw};
}

double chi2Of(const PoseEdge& edge, const Pose2& from, const Pose2& to) {
  const Eigen::Vector3d error = edgeError(edge.measured, from, to);
  return error.dot(edge.information * error);
}

double chi2Of(const PoseEdge& edge, const PoseGraph& graph) {
  return chi2Of(edge, graph.vertices[edge.from].pose, graph.vertices[edge.to].pose);
}

}  // namespace kestrel
