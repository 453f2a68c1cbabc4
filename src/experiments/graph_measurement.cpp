// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/graph_measurement.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <complex>
#include <vector>

#include "kestrel_slam/experiments/processor_time.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/graph/initial_poses.h"
#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/graph/robust_optimizer.h"

namespace kestrel {
namespace {

using Complex = std::complex<double>;
using SparseComplex = Eigen::SparseMatrix<Complex>;

/// The weights of [Rosen 2019]: 2 / trace of the covariance of the position, and twice that of yaw.
PoseGraph isotropic(PoseGraph graph) {
  for (PoseEdge& edge : graph.edges) {
    const double position = 2.0 / edge.information.topLeftCorner<2, 2>().inverse().trace();
    const double yaw = 2.0 * edge.information(2, 2);
    edge.information = Eigen::Vector3d(position, position, yaw).asDiagonal();
  }
  return graph;
}

OptimizerResult optimizeExactly(PoseGraph& graph, bool chordal) {
  OptimizerOptions options;
  options.kernel_scale = 0.0;
  options.min_decrease = 1e-13;
  options.chordal = chordal;
  return optimize(graph, options);
}

/// The chordal cost of an isotropic graph as a quadratic form in the complex numbers of positions
/// and, after them, rotations: x* M x.
SparseComplex quadraticForm(const PoseGraph& graph) {
  const auto n = static_cast<Eigen::Index>(graph.vertices.size());
  std::vector<Eigen::Triplet<Complex>> entries;
  // Adds weight |sum of factor_i x_i|².
  const auto add = [&](double weight, const std::vector<std::pair<Eigen::Index, Complex>>& terms) {
    for (const auto& [row, a] : terms) {
      for (const auto& [column, b] : terms) {
        entries.emplace_back(row, column, weight * std::conj(a) * b);
      }
    }
  };
  for (const PoseEdge& edge : graph.edges) {
    const auto from = static_cast<Eigen::Index>(edge.from), to = static_cast<Eigen::Index>(edge.to);
    const Complex shift(edge.measured.x, edge.measured.y);
    add(edge.information(0, 0), {{to, 1.0}, {from, -1.0}, {n + from, -shift}});
    add(edge.information(2, 2), {{n + to, 1.0}, {n + from, -std::polar(1.0, edge.measured.yaw)}});
  }
  SparseComplex form(2 * n, 2 * n);
  form.setFromTriplets(entries.begin(), entries.end());
  return form;
}

Eigen::VectorXcd complexOf(const PoseGraph& graph) {
  const auto n = static_cast<Eigen::Index>(graph.vertices.size());
  Eigen::VectorXcd x(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Pose2& pose = graph.vertices[static_cast<std::size_t>(i)].pose;
    x[i] = Complex(pose.x, pose.y);
    x[n + i] = std::polar(1.0, pose.yaw);
  }
  return x;
}

bool isPositive(const SparseComplex& matrix) {
  // The position of the first vertex is free: without its row and column.
  const SparseComplex part = matrix.bottomRightCorner(matrix.rows() - 1, matrix.cols() - 1);
  const Eigen::SimplicialLDLT<SparseComplex> factor(part);
  return factor.info() == Eigen::Success && factor.vectorD().real().minCoeff() > 0.0;
}

/// For any multipliers of |z_i| = 1 with M - diag(multipliers) + shift >= 0, their sum less n shift
/// is a lower bound of the cost. Takes the best power of ten for the shift; 0 if none is small.
double lowerBound(const PoseGraph& graph, double cost) {
  const auto n = static_cast<Eigen::Index>(graph.vertices.size());
  const SparseComplex form = quadraticForm(graph);
  const Eigen::VectorXcd x = complexOf(graph), gradient = form * x;
  Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(2 * n);
  for (Eigen::Index i = n; i < 2 * n; ++i)
    multipliers[i] = std::real(std::conj(x[i]) * gradient[i]);
  for (const double gap : {1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
    const double shift = gap * cost / static_cast<double>(n);
    SparseComplex shifted = form;
    for (Eigen::Index i = n; i < 2 * n; ++i) shifted.coeffRef(i, i) += shift - multipliers[i];
    if (isPositive(shifted)) return multipliers.sum() - gap * cost;
  }
  return 0.0;
}

std::size_t below(Random& random, std::size_t end) {
  return static_cast<std::size_t>(random.uniform() * static_cast<double>(end));
}

Pose2 nearly(Random& random) {
  return {0.3 * random.gaussian(), 0.3 * random.gaussian(), 0.17 * random.gaussian()};
}

/// Two vertices, each with `group` - 1 successors, that are at least `gap` apart.
std::pair<std::size_t, std::size_t> places(Random& random, std::size_t vertices, std::size_t group,
                                           std::size_t gap) {
  for (;;) {
    const std::size_t a = below(random, vertices - group), b = below(random, vertices - group);
    if (std::max(a, b) - std::min(a, b) >= gap) return {a, b};
  }
}

constexpr std::size_t kGroup = 10, kFar = 20;  // vertices

}  // namespace

CertifiedOptimum certifiedOptimum(const PoseGraph& graph) {
  CertifiedOptimum result;
  PoseGraph full = graph, even = isotropic(graph);
  const double begin = processorSeconds();
  placeByRotations(full);
  OptimizerOptions plain;
  plain.kernel_scale = 0.0;
  const OptimizerResult solved = optimize(full, plain);
  result.milliseconds = 1e3 * (processorSeconds() - begin);
  result.chi2 = solved.final_cost;
  result.steps = solved.iterations;
  placeByRotations(even);
  result.cost = optimizeExactly(even, true).final_cost;
  result.lower_bound = lowerBound(even, result.cost);
  return result;
}

const char* toString(FalseLoops kind) {
  switch (kind) {
    case FalseLoops::kRandom:
      return "random";
    case FalseLoops::kLocal:
      return "local";
    case FalseLoops::kGrouped:
      return "grouped";
    default:
      return "aliased";
  }
}

void addFalseLoops(FalseLoops kind, std::size_t count, std::uint64_t seed, PoseGraph& graph) {
  Random random(seed);
  const Eigen::Matrix3d information = graph.edges.back().information;
  const bool grouped = kind == FalseLoops::kGrouped || kind == FalseLoops::kAliased;
  const std::size_t group = grouped ? kGroup : 1, end = graph.edges.size() + count;
  while (graph.edges.size() < end) {
    auto [a, b] = places(random, graph.vertices.size(), group + kFar, kFar);
    if (kind == FalseLoops::kLocal) b = a + 2 + below(random, kFar - 2);
    const Pose2 common = nearly(random);
    const auto pose = [&, from = a, to = b](std::size_t i) {  // of `to` + i, seen from `from` + i
      const Pose2 a_T_ai = graph.vertices[from].pose.between(graph.vertices[from + i].pose);
      const Pose2 b_T_bi = graph.vertices[to].pose.between(graph.vertices[to + i].pose);
      return a_T_ai.inverse() * common * b_T_bi;
    };
    for (std::size_t i = 0; i < group && graph.edges.size() < end; ++i) {
      const Pose2 measured = kind == FalseLoops::kAliased ? pose(i) : nearly(random);
      graph.edges.push_back({a + i, b + i, measured, information, EdgeKind::kLoop});
    }
  }
}

RobustScore scoreRobustly(const PoseGraph& graph, std::size_t first_false,
                          const PoseGraph& reference) {
  const RobustOptions options;
  RobustScore score;
  PoseGraph solved = graph;
  const double begin = processorSeconds();
  const RobustResult result = optimizeRobustly(solved, options);
  score.seconds = processorSeconds() - begin;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].kind != EdgeKind::kLoop) continue;
    const bool is_true = i < first_false;
    if (!is_true && chi2Of(graph.edges[i], reference) <= options.max_chi2) continue;
    ++(is_true ? score.true_loops : score.false_loops);
    if (result.accepted[i]) ++(is_true ? score.true_accepted : score.false_accepted);
  }
  for (std::size_t i = 0; i < solved.vertices.size(); ++i) {
    const Eigen::Vector2d error =
        solved.vertices[i].pose.translation() - reference.vertices[i].pose.translation();
    score.max_error_m = std::max(score.max_error_m, error.norm());
  }
  return score;
}

}  // namespace kestrel
