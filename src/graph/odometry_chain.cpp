// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_chain.h"

#include <Eigen/LU>

namespace kestrel {

void OdometryChain::grow(const PoseGraph& graph) {
  const std::size_t first = size();
  std::vector<const PoseEdge*> edges(graph.vertices.size() - first);  // to each new vertex
  for (; edges_ < graph.edges.size(); ++edges_) {
    const PoseEdge& edge = graph.edges[edges_];
    if (edge.kind != EdgeKind::kOdometry || edge.to != edge.from + 1) continue;
    if (edge.to >= first) edges[edge.to - first] = &edge;
  }
  for (std::size_t i = first; i < graph.vertices.size(); ++i) {
    const PoseEdge* const edge = edges[i - first];
    if (edge == nullptr) {
      parts_.push_back(i == 0 ? 0 : parts_.back() + 1);
      poses_.emplace_back();
      noise_.emplace_back(Eigen::Matrix3d::Zero());
      continue;
    }
    parts_.push_back(parts_.back());
    poses_.push_back(poses_.back() * edge->measured);
    const Eigen::Matrix3d adjoint = poses_.back().adjoint();
    noise_.emplace_back(noise_.back() +
                        adjoint * edge->information.inverse() * adjoint.transpose());
  }
}

}  // namespace kestrel
