// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// The poses base_T_vertex of an optimized graph, with their covariances (in the tangent space of
/// base_T_vertex): the marginals of the joint normal distribution of all edges at the optimum.
///
/// `edge_weights` are those of OptimizerResult; empty: all are 1. The covariance is that of a fixed
/// `base`, whichever vertices the optimizer held, unless the graph has fixed vertices. There is no
/// value for a vertex that no edges connect to `base`, unless fixed vertices tell where both are,
/// and none at all if the graph has an error. The cost is one sparse factorization, and three
/// solutions with it for each vertex.
std::vector<std::optional<GaussianPose2>> marginals(const PoseGraph& graph,
                                                    const std::vector<double>& edge_weights,
                                                    std::size_t base,
                                                    const std::vector<std::size_t>& vertices);

}  // namespace kestrel
