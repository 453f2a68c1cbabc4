// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/graph_uncertainty.h"

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace kestrel {
namespace {

/// The edges of every vertex, in one list.
class Neighbors {
 public:
  explicit Neighbors(const PoseGraph& graph) : first_(graph.vertices.size() + 1, 0) {
    for (const PoseEdge& edge : graph.edges) ++first_[edge.from + 1], ++first_[edge.to + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    edges_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < graph.edges.size(); ++i) {
      edges_[next[graph.edges[i].from]++] = i;
      edges_[next[graph.edges[i].to]++] = i;
    }
  }

  template <typename Visit>
  void forEachEdge(std::size_t vertex, Visit visit) const {
    for (std::size_t i = first_[vertex]; i < first_[vertex + 1]; ++i) visit(edges_[i]);
  }

 private:
  std::vector<std::size_t> first_, edges_;
};

/// A vertex at the end of the shortest path.
struct Reached {
  double length = std::numeric_limits<double>::infinity();  ///< m²
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();     ///< x, y in the axes of the map, yaw
};

/// The covariance after a step, to which the edge adds the variances of `edge`.
Eigen::Matrix3d moved(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& step,
                      const Eigen::Matrix3d& edge) {
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned.topRightCorner<2, 1>() = Eigen::Vector2d(-step.y(), step.x());
  Eigen::Matrix3d result = turned * covariance * turned.transpose();
  // The axes of the edge do not matter: only the sum of x and y is used.
  result.diagonal() += edge.diagonal();
  return result;
}

}  // namespace

double RelativeUncertainty::sigmaAt(double distance_m) const {
  return std::sqrt(position_m2 + yaw_rad2 * distance_m * distance_m);
}

/// The shortest path [Dijkstra 1959], with the sum of the edges' position variances as length.
std::vector<RelativeUncertainty> uncertaintiesFrom(const PoseGraph& graph, std::size_t from) {
  const Neighbors neighbors(graph);
  std::vector<Reached> reached(graph.vertices.size());
  using Entry = std::pair<double, std::size_t>;  // length, vertex
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  reached[from].length = 0.0;
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [length, at] = open.top();
    open.pop();
    if (length > reached[at].length) continue;
    neighbors.forEachEdge(at, [&, length = length, at = at](std::size_t i) {
      const PoseEdge& edge = graph.edges[i];
      const std::size_t to = edge.from == at ? edge.to : edge.from;
      const Eigen::Matrix3d covariance = edge.information.inverse();
      const double next = length + covariance(0, 0) + covariance(1, 1);
      if (next >= reached[to].length) return;
      const Eigen::Vector2d step =
          graph.vertices[to].pose.translation() - graph.vertices[at].pose.translation();
      reached[to] = {next, moved(reached[at].covariance, step, covariance)};
      open.emplace(next, to);
    });
  }
  std::vector<RelativeUncertainty> result(reached.size());
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const Eigen::Matrix3d& covariance = reached[i].covariance;
    if (std::isfinite(reached[i].length))
      result[i] = {covariance(0, 0) + covariance(1, 1), covariance(2, 2)};
  }
  return result;
}

}  // namespace kestrel
