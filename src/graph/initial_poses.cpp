// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/initial_poses.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <complex>
#include <deque>

namespace kestrel {
namespace {

using Complex = std::complex<double>;

/// The edges at each vertex.
std::vector<std::vector<std::size_t>> edgesAt(const PoseGraph& graph) {
  std::vector<std::vector<std::size_t>> edges(graph.vertices.size());
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    edges[graph.edges[i].from].push_back(i);
    edges[graph.edges[i].to].push_back(i);
  }
  return edges;
}

/// Places the vertices at the edges of those that are placed already. Odometry is followed as far
/// as it leads before the next loop is.
class Placement {
 public:
  explicit Placement(PoseGraph& graph) : graph_(graph), edges_(edgesAt(graph)) {
    placed_.resize(graph.vertices.size());
  }

  void run() {
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (graph_.vertices[i].fixed) start(i);
    }
    spread();
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (!placed_[i]) start(i);
      spread();
    }
  }

 private:
  void start(std::size_t vertex) {
    placed_[vertex] = true;
    for (const std::size_t edge : edges_[vertex]) {
      if (graph_.edges[edge].kind == EdgeKind::kOdometry) {
        waiting_.push_front(edge);
      } else {
        waiting_.push_back(edge);
      }
    }
  }

  void spread() {
    while (!waiting_.empty()) {
      const PoseEdge& edge = graph_.edges[waiting_.front()];
      waiting_.pop_front();
      if (placed_[edge.from] && placed_[edge.to]) continue;
      const bool forward = placed_[edge.from];
      const std::size_t known = forward ? edge.from : edge.to, next = forward ? edge.to : edge.from;
      graph_.vertices[next].pose =
          graph_.vertices[known].pose * (forward ? edge.measured : edge.measured.inverse());
      start(next);
    }
  }

  PoseGraph& graph_;
  std::vector<std::vector<std::size_t>> edges_;
  std::vector<bool> placed_;
  std::deque<std::size_t> waiting_;  // edges at vertices that are placed
};

/// Linear least squares over a complex number for each vertex: w |z_to - turn z_from - shift|².
class ComplexLeastSquares {
 public:
  explicit ComplexLeastSquares(const PoseGraph& graph) {
    for (const bool held : heldVertices(graph)) rows_.push_back(held ? kHeld : size_++);
    right_ = Eigen::VectorXcd::Zero(size_);
  }

  void add(const PoseEdge& edge, double weight, Complex turn, Complex shift,
           const std::vector<Complex>& held) {
    const Eigen::Index from = rows_[edge.from], to = rows_[edge.to];
    if (to != kHeld) {
      entries_.emplace_back(to, to, weight);
      right_[to] += weight * (shift + (from == kHeld ? turn * held[edge.from] : 0.0));
    }
    if (from != kHeld) {
      entries_.emplace_back(from, from, weight * std::norm(turn));
      right_[from] += weight * std::conj(turn) * ((to == kHeld ? held[edge.to] : 0.0) - shift);
    }
    if (from == kHeld || to == kHeld) return;
    entries_.emplace_back(to, from, -weight * turn);
    entries_.emplace_back(from, to, -weight * std::conj(turn));
  }

  /// Replaces the values of the vertices that are not held.
  bool solve(std::vector<Complex>& values) const {
    if (size_ == 0) return true;
    Eigen::SparseMatrix<Complex> matrix(size_, size_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> factor(matrix);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXcd solution = factor.solve(right_);
    if (!solution.allFinite()) return false;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i] != kHeld) values[i] = solution[rows_[i]];
    }
    return true;
  }

 private:
  static constexpr Eigen::Index kHeld = -1;
  std::vector<Eigen::Index> rows_;
  Eigen::Index size_ = 0;
  std::vector<Eigen::Triplet<Complex>> entries_;
  Eigen::VectorXcd right_;
};

}  // namespace

void placeAlongEdges(PoseGraph& graph) { Placement(graph).run(); }

bool placeByRotations(PoseGraph& graph) {
  if (!problemOf(graph).empty()) return false;
  std::vector<Complex> turns, positions;
  for (const PoseVertex& vertex : graph.vertices) {
    turns.push_back(std::polar(1.0, vertex.pose.yaw));
    positions.emplace_back(vertex.pose.x, vertex.pose.y);
  }
  ComplexLeastSquares rotations(graph), translations(graph);
  for (const PoseEdge& edge : graph.edges) {
    rotations.add(edge, edge.information(2, 2), std::polar(1.0, edge.measured.yaw), 0.0, turns);
  }
  if (!rotations.solve(turns)) return false;
  for (const PoseEdge& edge : graph.edges) {
    const Complex turn = std::polar(1.0, std::arg(turns[edge.from]));
    const double weight = 0.5 * (edge.information(0, 0) + edge.information(1, 1));
    translations.add(edge, weight, 1.0, turn * Complex(edge.measured.x, edge.measured.y),
                     positions);
  }
  if (!translations.solve(positions)) return false;
  for (std::size_t i = 0; i < turns.size(); ++i) {
    graph.vertices[i].pose = {positions[i].real(), positions[i].imag(), std::arg(turns[i])};
  }
  return true;
}

}  // namespace kestrel
