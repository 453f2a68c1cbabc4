// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/graph_uncertainty.h"

#include <Eigen/LU>
#include <cmath>
#include <functional>
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

}  // namespace

double RelativeUncertainty::sigmaAt(double distance_m) const {
  return std::sqrt(position_m2 + yaw_rad2 * distance_m * distance_m);
}

/// The shortest path [Dijkstra 1959], with the variance of the position as length.
std::vector<RelativeUncertainty> uncertaintiesFrom(const PoseGraph& graph, std::size_t from) {
  const Neighbors neighbors(graph);
  std::vector<RelativeUncertainty> result(graph.vertices.size());
  using Entry = std::pair<double, std::size_t>;  // variance, vertex
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  result[from] = {0.0, 0.0};
  open.emplace(0.0, from);
  while (!open.empty()) {
    const auto [variance, at] = open.top();
    open.pop();
    if (variance > result[at].position_m2) continue;
    neighbors.forEachEdge(at, [&, variance = variance, at = at](std::size_t i) {
      const PoseEdge& edge = graph.edges[i];
      const std::size_t to = edge.from == at ? edge.to : edge.from;
      const Eigen::Matrix3d covariance = edge.information.inverse();
      const double next = variance + covariance(0, 0) + covariance(1, 1);
      if (next >= result[to].position_m2) return;
      result[to] = {next, result[at].yaw_rad2 + covariance(2, 2)};
      open.emplace(next, to);
    });
  }
  return result;
}

}  // namespace kestrel
