// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// The joint normal distribution of the poses of an optimized graph. One sparse factorization when
/// it is made, and a few solutions with it for each question.
class GraphMarginals {
 public:
  /// `edge_weights` are those of OptimizerResult; empty: all are 1.
  GraphMarginals(const PoseGraph& graph, const std::vector<double>& edge_weights);
  ~GraphMarginals();
  GraphMarginals(GraphMarginals&&) noexcept;
  GraphMarginals& operator=(GraphMarginals&&) noexcept;

  /// The pose from_T_to with its covariance (in the tangent space of from_T_to). It does not depend
  /// on the vertices that the optimizer held, unless the graph has fixed vertices. Nothing if no
  /// edges connect the two, unless fixed vertices tell where both are; or if the graph has an
  /// error.
  std::optional<GaussianPose2> between(std::size_t from, std::size_t to) const;

  /// The same if the errors of the edges have these covariances, in the tangent space of their
  /// measurements, while the optimizer weighed the edges with their information.
  std::optional<GaussianPose2> between(std::size_t from, std::size_t to,
                                       const std::vector<Eigen::Matrix3d>& edge_covariances) const;

 private:
  struct Joint;
  std::unique_ptr<Joint> joint_;
};

/// GraphMarginals::between(base, vertex) for several vertices.
std::vector<std::optional<GaussianPose2>> marginals(const PoseGraph& graph,
                                                    const std::vector<double>& edge_weights,
                                                    std::size_t base,
                                                    const std::vector<std::size_t>& vertices);

}  // namespace kestrel
