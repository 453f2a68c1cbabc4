// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/optimizer.h"
#include "kestrel_slam/graph/pairwise_consistency.h"

namespace kestrel {

struct RobustOptions {
  ConsistencyOptions consistency;
  OptimizerOptions optimizer;
  /// Of a loop in the optimized graph; larger ones are refused. Three degrees of freedom, 0.1 %.
  double max_chi2 = 16.266;
  /// The expected number of loops that would agree with a false loop by chance. A loop is accepted
  /// only if the agreement that speaks for it has a smaller one.
  double max_chance = 0.001;
  /// Of optimizing and judging all loops again.
  int max_rounds = 10;
};

struct RobustResult {
  OptimizerResult optimizer;   ///< of the odometry and the accepted loops, in this order
  std::vector<bool> accepted;  ///< for each edge of the graph; always true for odometry
  /// Loops in the largest consistent set, when step 1 was done the last time.
  std::size_t first = 0;
  std::size_t second = 0;  ///< loops in the largest set that contradicts it
  bool exact = true;       ///< false: these sets may not be the largest ones
};

/// Optimizes a graph that may have false loops.
///
/// 1. The largest set of loops that agree pair by pair (ConsistentLoops), between each two parts of
///    the odometry; none where a second set has more than half as many. Of this set, those that
///    agree with another one, or with the odometry, so closely that chance does not explain it.
/// 2. These loops form clusters that support each other. They are accepted one cluster after the
///    other, the largest first, and the graph is optimized each time. A cluster that contradicts
///    the graph is left out: where the odometry alone is too vague to refute a false place, the
///    graph that the larger clusters have given often is not.
/// 3. Loops that do not fit into the optimized graph are refused for good. Others are accepted if
///    they agree with it so closely that chance does not explain it. Then the graph is optimized
///    again. Step 1 is done again without the refused loops, until nothing changes.
///
/// Chance is judged for errors that are spread evenly over the area of the odometry and over all
/// yaws. The initial poses of the vertices are not used, except of those that are held.
RobustResult optimizeRobustly(PoseGraph& graph, const RobustOptions& options = {});

}  // namespace kestrel
