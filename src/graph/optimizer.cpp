// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/optimizer.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "kestrel_slam/geometry/square.h"

namespace kestrel {
namespace {

/// The scales of the kernel of one optimization after the other, as factors.
constexpr std::array<double, 3> kScaleFactors = {30.0, 5.0, 1.0};

/// The share of the cost at which an optimization ends that another one follows.
constexpr double kRoughDecrease = 1e-3;

/// So large that the first steps are those of Gauss-Newton: most graphs need no damping.
constexpr double kTrustRegion = 1e8;

/// The Cauchy kernel. Its scale changes between optimizations.
class CauchyKernel : public ceres::LossFunction {
 public:
  void setScale(double scale) { square_ = scale * scale; }

  double cost(double chi2) const { return square_ * std::log1p(chi2 / square_); }
  double weight(double chi2) const { return 1.0 / (1.0 + chi2 / square_); }

  void Evaluate(double chi2, double* cost_and_derivatives) const override {
    const double w = weight(chi2);
    cost_and_derivatives[0] = cost(chi2);
    cost_and_derivatives[1] = w;
    cost_and_derivatives[2] = -w * w / square_;
  }

 private:
  double square_ = 1.0;
};

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Pose2 poseOf(const double* components) { return {components[0], components[1], components[2]}; }

double chordOf(double angle) { return 2.0 * std::sin(0.5 * angle); }

/// The error of an edge, in standard deviations.
class EdgeCost : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  EdgeCost(const PoseEdge& edge, bool chordal)
      : measured_(edge.measured), root_(edge.information.llt().matrixU()), chordal_(chordal) {}

  bool Evaluate(double const* const* poses, double* residual, double** jacobians) const override {
    Eigen::Matrix3d J_from, J_to;
    Eigen::Vector3d error =
        edgeError(measured_, poseOf(poses[0]), poseOf(poses[1]), &J_from, &J_to);
    if (chordal_) {
      const double slope = std::cos(0.5 * error.z());
      J_from.row(2) *= slope;
      J_to.row(2) *= slope;
      error.z() = chordOf(error.z());
    }
    Eigen::Map<Eigen::Vector3d>(residual, 3) = root_ * error;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<RowMajor3d>(jacobians[0], 3, 3) = root_ * J_from;
    if (jacobians[1] != nullptr) Eigen::Map<RowMajor3d>(jacobians[1], 3, 3) = root_ * J_to;
    return true;
  }

 private:
  Pose2 measured_;
  Eigen::Matrix3d root_;  // root' root = information
  bool chordal_;
};

ceres::Problem::Options problemOptions() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;  // the graph was checked
  return options;
}

/// The optimization of one graph.
class Optimization {
 public:
  Optimization(PoseGraph& graph, const OptimizerOptions& options)
      : graph_(graph), options_(options), problem_(problemOptions()) {
    kernel_.setScale(options.kernel_scale);
    for (const PoseVertex& v : graph.vertices) poses_.push_back({v.pose.x, v.pose.y, v.pose.yaw});
    for (const PoseEdge& edge : graph.edges) {
      problem_.AddResidualBlock(new EdgeCost(edge, options.chordal),
                                isRobust(edge) ? &kernel_ : nullptr, poses_[edge.from].data(),
                                poses_[edge.to].data());
    }
    const std::vector<bool> held = heldVertices(graph);
    for (std::size_t i = 0; i < held.size(); ++i) {
      double* const pose = poses_[i].data();
      if (held[i] && problem_.HasParameterBlock(pose)) problem_.SetParameterBlockConstant(pose);
    }
  }

  OptimizerResult run() {
    OptimizerResult result;
    result.initial_cost = evaluate(result);
    if (!std::isfinite(result.initial_cost)) {
      result.problem = "the numbers are too large: the cost is not finite";
      return result;
    }
    constexpr std::size_t kLast = kScaleFactors.size() - 1;
    for (std::size_t i = firstStage(result.edge_chi2); i <= kLast; ++i) {
      kernel_.setScale(kScaleFactors[i] * options_.kernel_scale);
      if (!solve(i == kLast ? options_.min_decrease : kRoughDecrease, result)) return result;
    }
    result.final_cost = evaluate(result);
    for (std::size_t i = 0; i < poses_.size(); ++i) graph_.vertices[i].pose = pose(i);
    return result;
  }

 private:
  bool isRobust(const PoseEdge& edge) const {
    return options_.kernel_scale > 0.0 && edge.kind == EdgeKind::kLoop;
  }

  Pose2 pose(std::size_t vertex) const { return poseOf(poses_[vertex].data()); }

  double chi2At(const PoseEdge& edge) const {
    Eigen::Vector3d error = edgeError(edge.measured, pose(edge.from), pose(edge.to));
    if (options_.chordal) error.z() = chordOf(error.z());
    return error.dot(edge.information * error);
  }

  /// Fills in the values of the edges, and returns the cost.
  double evaluate(OptimizerResult& result) const {
    double cost = 0.0;
    result.edge_chi2.clear();
    result.edge_weights.clear();
    for (const PoseEdge& edge : graph_.edges) {
      const double chi2 = chi2At(edge);
      result.edge_chi2.push_back(chi2);
      result.edge_weights.push_back(isRobust(edge) ? kernel_.weight(chi2) : 1.0);
      cost += isRobust(edge) ? kernel_.cost(chi2) : chi2;
    }
    return cost;
  }

  /// The narrowest kernel that leaves the worst loop half of its weight, if that is a bad one.
  std::size_t firstStage(const std::vector<double>& chi2) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < chi2.size(); ++i) {
      if (isRobust(graph_.edges[i])) worst = std::max(worst, chi2[i]);
    }
    std::size_t stage = kScaleFactors.size() - 1;
    if (worst <= options_.graduate_above_chi2) return stage;
    while (stage > 0 && worst > square(kScaleFactors[stage] * options_.kernel_scale)) --stage;
    return stage;
  }

  bool solve(double min_decrease, OptimizerResult& result) {
    ceres::Solver::Summary summary;
    ceres::Solve(solverOptions(min_decrease), &problem_, &summary);
    result.iterations += summary.num_successful_steps + summary.num_unsuccessful_steps - 1;
    result.converged = summary.termination_type == ceres::CONVERGENCE;
    if (!summary.IsSolutionUsable()) result.problem = "no step could be computed";
    return summary.IsSolutionUsable();
  }

  ceres::Solver::Options solverOptions(double min_decrease) const {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    // SuiteSparse calls BLAS, whose results depend on what is installed.
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.num_threads = 1;
    options.max_num_iterations = options_.max_iterations;
    options.initial_trust_region_radius = kTrustRegion;
    options.function_tolerance = min_decrease;
    options.gradient_tolerance = 0.0;   // its unit is that of the graph
    options.parameter_tolerance = 0.0;  // relative to the size of the map
    options.logging_type = ceres::SILENT;
    return options;
  }

  PoseGraph& graph_;
  const OptimizerOptions options_;
  CauchyKernel kernel_;
  std::vector<std::array<double, 3>> poses_;  // x, y, yaw of each vertex
  ceres::Problem problem_;
};

}  // namespace

OptimizerResult optimize(PoseGraph& graph, const OptimizerOptions& options) {
  OptimizerResult result;
  result.problem = problemOf(graph);
  return result.ok() ? Optimization(graph, options).run() : result;
}

}  // namespace kestrel
