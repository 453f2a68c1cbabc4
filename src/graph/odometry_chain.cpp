// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/odometry_chain.h"

#include <Eigen/LU>
#include <algorithm>

namespace kestrel {

void OdometryChain::grow(const PoseGraph& graph) {
  const std::size_t first = size();
  std::vector<const PoseEdge*> edges(graph.vertices.size() - first);  // to each new vertex
  for (; edges_ < graph.edges.size(); ++edges_) {
    const PoseEdge& edge = graph.edges[edges_];
    const std::size_t last = std::max(edge.from, edge.to);
    if (edge.kind != EdgeKind::kOdometry || std::min(edge.from, edge.to) + 1 != last) continue;
    if (last >= first) edges[last - first] = &edge;
  }
  for (std::size_t i = first; i < graph.vertices.size(); ++i) {
    const PoseEdge* const edge = edges[i - first];
    if (edge == nullptr) {
      parts_.push_back(i == 0 ? 0 : parts_.back() + 1);
      poses_.emplace_back();
      noise_.emplace_back(Eigen::Matrix3d::Zero());
      continue;
    }
    // The noise of an edge is at its vertex `to`, which may be the earlier one.
    const bool forward = edge->to == i;
    const Pose2 next = poses_.back() * (forward ? edge->measured : edge->measured.inverse());
    const Eigen::Matrix3d adjoint = (forward ? next : poses_.back()).adjoint();
    parts_.push_back(parts_.back());
    poses_.push_back(next);
    noise_.emplace_back(noise_.back() +
                        adjoint * edge->information.inverse() * adjoint.transpose());
  }
}

}  // namespace kestrel
