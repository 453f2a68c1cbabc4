// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// How uncertain one vertex is relative to another one.
struct RelativeUncertainty {
  double position_m2 = 1e9;  ///< variance of the position, sum of x and y
  double yaw_rad2 = 1e9;     ///< variance of the yaw

  /// false: no path of edges leads there.
  bool isKnown() const { return position_m2 < 1e9; }
  /// Standard deviation of the position of a point at a distance from that vertex, m.
  double sigmaAt(double distance_m) const;
};

/// Uncertainty of all vertices relative to `from`, along the most certain path of edges, at the
/// current poses: an error of the yaw moves what follows. It is larger than the marginal
/// covariance, which uses all paths, and costs much less.
std::vector<RelativeUncertainty> uncertaintiesFrom(const PoseGraph& graph, std::size_t from);

}  // namespace kestrel
