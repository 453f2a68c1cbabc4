// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

struct OptimizerOptions {
  /// Scale s of the Cauchy kernel s² log(1 + chi2 / s²) of loops, in standard deviations: a loop
  /// with chi2 = s² has half its weight. 0: no kernel.
  double kernel_scale = 3.0;
  /// If a loop begins with a larger chi2, the graph is optimized with wider kernels before that of
  /// s: 5 s, and before that 30 s if the chi2 is above (5 s)². A narrow kernel at once rejects a
  /// true loop that closes a large error.
  double graduate_above_chi2 = 100.0;
  /// Of each of the up to three optimizations.
  int max_iterations = 100;
  /// The optimization has converged when a step lowers the cost by a smaller share.
  double min_decrease = 1e-8;
  /// The error of a yaw is 2 sin(angle / 2) instead of the angle, as in [Rosen 2019]. It has no
  /// step at half a turn.
  bool chordal = false;
};

struct OptimizerResult {
  /// Why nothing was done: the graph has an error (problemOf), or no step could be computed. Then
  /// the graph is not changed. "" otherwise.
  std::string problem;
  bool converged = false;     ///< not stopped by max_iterations
  int iterations = 0;         ///< steps of all optimizations
  double initial_cost = 0.0;  ///< sum over all edges of the kernel of scale s of chi2
  double final_cost = 0.0;
  std::vector<double> edge_chi2;     ///< at the end, without kernel
  std::vector<double> edge_weights;  ///< at the end, of the kernel, in (0, 1]; 1 for odometry

  bool ok() const { return problem.empty(); }
};

/// Moves the vertices to the poses with the smallest cost: the maximum likelihood of all edges,
/// with a robust kernel on loops. Levenberg-Marquardt with a sparse Cholesky factorization (Ceres),
/// single threaded; the same input gives the same result, bit for bit. The vertices of
/// heldVertices() stay.
OptimizerResult optimize(PoseGraph& graph, const OptimizerOptions& options = {});

}  // namespace kestrel
