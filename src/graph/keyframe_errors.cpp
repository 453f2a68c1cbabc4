// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/keyframe_errors.h"

#include <Eigen/LU>

namespace kestrel {

KeyframeMarginals::KeyframeMarginals(const PoseGraph& graph,
                                     const std::vector<KeyframeErrors>& errors,
                                     const std::vector<double>& edge_weights)
    : errors_(errors), marginals_(graph, edge_weights) {
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseEdge& edge = graph.edges[i];
    const bool is_motion = edge.kind == EdgeKind::kOdometry && edge.from + 1 == edge.to;
    const double weight = edge_weights.empty() ? 1.0 : edge_weights[i];
    edges_.push_back(is_motion ? errors[edge.to].lasting
                               : Eigen::Matrix3d(edge.information.inverse() / weight));
  }
}

std::optional<GaussianPose2> KeyframeMarginals::between(std::size_t first,
                                                        std::size_t keyframe) const {
  const std::optional<GaussianPose2> motion = marginals_.between(first, keyframe, edges_);
  if (!motion) return std::nullopt;
  return compose({Pose2(), errors_[first].lasting}, *motion);
}

}  // namespace kestrel
