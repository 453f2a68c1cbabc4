// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/marginals.h"

#include <Eigen/SparseCholesky>

namespace kestrel {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3>;

constexpr Eigen::Index kHeld = -1;

/// The joint distribution of the poses that are not held, in the axes of map.
class JointDistribution {
 public:
  JointDistribution(const PoseGraph& graph, const std::vector<double>& weights)
      : graph_(graph), weights_(weights) {
    for (const bool held : heldVertices(graph)) {
      rows_.push_back(held ? kHeld : size_);
      if (!held) size_ += 3;
    }
    SparseMatrix information(size_, size_);
    const std::vector<Eigen::Triplet<double>> entries = entriesOf();
    information.setFromTriplets(entries.begin(), entries.end());
    if (size_ > 0) factor_.compute(information);
    valid_ = size_ == 0 || factor_.info() == Eigen::Success;
  }

  bool isValid() const { return valid_; }

  /// The covariance of all poses with that of `vertex`.
  Columns columnsOf(std::size_t vertex) const {
    Columns unit = Columns::Zero(size_, 3);
    if (size_ == 0 || rows_[vertex] == kHeld) return unit;
    unit.middleRows<3>(rows_[vertex]).setIdentity();
    return factor_.solve(unit);
  }

  Eigen::Matrix3d blockOf(std::size_t vertex, const Columns& columns) const {
    if (rows_[vertex] == kHeld) return Eigen::Matrix3d::Zero();
    return columns.middleRows<3>(rows_[vertex]);
  }

  /// The error of a vertex, whose columns these are, for each component of the error of an edge.
  Eigen::Matrix3d effectOf(std::size_t edge, const Columns& columns) const {
    const PoseEdge& e = graph_.edges[edge];
    Eigen::Matrix3d J_from, J_to;
    edgeError(e.measured, graph_.vertices[e.from].pose, graph_.vertices[e.to].pose, &J_from, &J_to);
    const Eigen::Matrix3d moved = J_from * blockOf(e.from, columns) + J_to * blockOf(e.to, columns);
    return moved.transpose() * informationOf(edge);
  }

 private:
  Eigen::Matrix3d informationOf(std::size_t edge) const {
    return (weights_.empty() ? 1.0 : weights_[edge]) * graph_.edges[edge].information;
  }

  std::vector<Eigen::Triplet<double>> entriesOf() const {
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      const PoseEdge& edge = graph_.edges[i];
      const Eigen::Matrix3d information = informationOf(i);
      Eigen::Matrix3d J_from, J_to;
      edgeError(edge.measured, graph_.vertices[edge.from].pose, graph_.vertices[edge.to].pose,
                &J_from, &J_to);
      add(edge.from, edge.from, J_from.transpose() * information * J_from, entries);
      add(edge.to, edge.to, J_to.transpose() * information * J_to, entries);
      const Eigen::Matrix3d mixed = J_from.transpose() * information * J_to;
      add(edge.from, edge.to, mixed, entries);
      add(edge.to, edge.from, mixed.transpose(), entries);
    }
    return entries;
  }

  void add(std::size_t row_vertex, std::size_t column_vertex, const Eigen::Matrix3d& block,
           std::vector<Eigen::Triplet<double>>& entries) const {
    const Eigen::Index row = rows_[row_vertex], column = rows_[column_vertex];
    if (row == kHeld || column == kHeld) return;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) entries.emplace_back(row + i, column + j, block(i, j));
    }
  }

  const PoseGraph& graph_;
  const std::vector<double> weights_;
  std::vector<Eigen::Index> rows_;  // first row of each vertex
  Eigen::Index size_ = 0;
  Eigen::SimplicialLDLT<SparseMatrix> factor_;
  bool valid_ = false;
};

/// Whether the distribution of base_T_vertex is known, by the connected part of each vertex.
class Reach {
 public:
  explicit Reach(const PoseGraph& graph) : parts_(connectedParts(graph)), located_(parts_.size()) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (graph.vertices[i].fixed) located_[parts_[i]] = true;
    }
  }

  bool joins(std::size_t a, std::size_t b) const {
    return parts_[a] == parts_[b] || (located_[parts_[a]] && located_[parts_[b]]);
  }

 private:
  std::vector<std::size_t> parts_;
  std::vector<bool> located_;  // by its fixed vertices
};

/// The rotation from the tangent space of a pose to the axes of map.
Eigen::Matrix3d axesOf(const Pose2& pose) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  axes.topLeftCorner<2, 2>() = pose.rotation();
  return axes;
}

}  // namespace

struct GraphMarginals::Joint {
  Joint(const PoseGraph& of, const std::vector<double>& weights)
      : graph(of), distribution(graph, weights), reach(graph) {}

  Eigen::Matrix3d tangentBlock(std::size_t row, std::size_t column, const Columns& columns) const {
    return axesOf(graph.vertices[row].pose).transpose() * distribution.blockOf(row, columns) *
           axesOf(graph.vertices[column].pose);
  }

  const PoseGraph graph;
  const JointDistribution distribution;
  const Reach reach;
};

GraphMarginals::GraphMarginals(const PoseGraph& graph, const std::vector<double>& edge_weights) {
  if (problemOf(graph).empty()) joint_ = std::make_unique<Joint>(graph, edge_weights);
  if (joint_ && !joint_->distribution.isValid()) joint_.reset();
}
GraphMarginals::~GraphMarginals() = default;
GraphMarginals::GraphMarginals(GraphMarginals&&) noexcept = default;
GraphMarginals& GraphMarginals::operator=(GraphMarginals&&) noexcept = default;

std::optional<GaussianPose2> GraphMarginals::between(std::size_t from, std::size_t to) const {
  if (!joint_ || !joint_->reach.joins(from, to)) return std::nullopt;
  const Columns a = joint_->distribution.columnsOf(from), b = joint_->distribution.columnsOf(to);
  return kestrel::between({joint_->graph.vertices[from].pose, joint_->tangentBlock(from, from, a)},
                          {joint_->graph.vertices[to].pose, joint_->tangentBlock(to, to, b)},
                          joint_->tangentBlock(from, to, b));
}

/// The errors of the edges, each with its effect on the motion: [Huber 1967] calls the sum a
/// sandwich.
std::optional<GaussianPose2> GraphMarginals::between(
    std::size_t from, std::size_t to, const std::vector<Eigen::Matrix3d>& edge_covariances) const {
  if (!joint_ || !joint_->reach.joins(from, to)) return std::nullopt;
  const Columns a = joint_->distribution.columnsOf(from), b = joint_->distribution.columnsOf(to);
  const Pose2 &map_T_from = joint_->graph.vertices[from].pose,
              &map_T_to = joint_->graph.vertices[to].pose;
  GaussianPose2 result{map_T_from.between(map_T_to), Eigen::Matrix3d::Zero()};
  const Eigen::Matrix3d of_from = result.mean.inverse().adjoint() * axesOf(map_T_from).transpose(),
                        of_to = axesOf(map_T_to).transpose();
  for (std::size_t i = 0; i < edge_covariances.size(); ++i) {
    const Eigen::Matrix3d effect =
        of_to * joint_->distribution.effectOf(i, b) - of_from * joint_->distribution.effectOf(i, a);
    result.covariance += effect * edge_covariances[i] * effect.transpose();
  }
  return result;
}

std::vector<std::optional<GaussianPose2>> marginals(const PoseGraph& graph,
                                                    const std::vector<double>& edge_weights,
                                                    std::size_t base,
                                                    const std::vector<std::size_t>& vertices) {
  const GraphMarginals joint(graph, edge_weights);
  std::vector<std::optional<GaussianPose2>> results;
  for (const std::size_t vertex : vertices) results.push_back(joint.between(base, vertex));
  return results;
}

}  // namespace kestrel
