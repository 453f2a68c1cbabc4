// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// The smallest cost that the optimizer finds for a graph, and how far above the optimum it may be.
struct CertifiedOptimum {
  double cost = 0.0;         ///< sum of chi2, chordal, of the graph made isotropic [Rosen 2019]
  double lower_bound = 0.0;  ///< of the cost of all poses; cost if the optimum is proven
  double chi2 = 0.0;         ///< of g2o, with the full information matrices, at its own optimum
  int steps = 0;
  double milliseconds =
      0.0;  ///< of the latter optimization, processor time, from linear least squares
};

/// Optimizes a copy of the graph. The bound comes from the dual problem of [Rosen 2019, sec. 4]: a
/// matrix that must be positive semidefinite at the optimum.
CertifiedOptimum certifiedOptimum(const PoseGraph& graph);

/// How false loops are made. In all of them two places are said to be within some 0.3 m and 10
/// degrees.
enum class FalseLoops {
  kRandom,   ///< any two places
  kLocal,    ///< places that are 2 to 20 vertices apart
  kGrouped,  ///< ten successive vertices with ten others, each loop with its own error
  kAliased,  ///< the same, but the ten loops agree with each other: a place that looks like another
};

const char* toString(FalseLoops kind);

/// Adds `count` false loops.
void addFalseLoops(FalseLoops kind, std::size_t count, std::uint64_t seed, PoseGraph& graph);

struct RobustScore {
  std::size_t true_loops = 0, true_accepted = 0;
  /// Without those that fit into `reference` by chance.
  std::size_t false_loops = 0, false_accepted = 0;
  double max_error_m = 0.0;  ///< largest distance of a vertex from that of `reference`
  double seconds = 0.0;      ///< processor time
};

/// Runs optimizeRobustly on a copy of `graph`. The loops before `first_false` are true. `reference`
/// has the right poses, as the optimum of the true loops.
RobustScore scoreRobustly(const PoseGraph& graph, std::size_t first_false,
                          const PoseGraph& reference);

}  // namespace kestrel
