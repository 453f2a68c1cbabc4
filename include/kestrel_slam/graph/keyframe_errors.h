// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/graph/marginals.h"
#include "kestrel_slam/graph/pose_graph.h"

namespace kestrel {

/// The parts of the error of a keyframe. Covariances, in the tangent space of its pose.
struct KeyframeErrors {
  /// What the motion from the keyframe before adds to this and to all later poses. Of the first
  /// one: the error of the map that it begins.
  Eigen::Matrix3d lasting = Eigen::Matrix3d::Zero();
  /// Of its match: in no other pose.
  Eigen::Matrix3d match = Eigen::Matrix3d::Zero();
};

/// What a graph says about the errors of poses over many edges. The errors of successive odometry
/// edges are not independent: the error of a match is in the edge to its keyframe and, with the
/// other sign, in the edge from it, so it cancels in their sum. The edges of an optimization have
/// all of it, and a reserve for each of them; over a thousand edges that makes decimeters. Here the
/// error of the odometry edge to a keyframe is KeyframeErrors::lasting. The optimizer weighed the
/// edges otherwise, which is taken into account: its result is not the best for these errors.
class KeyframeMarginals {
 public:
  /// `errors`: of every vertex. `edge_weights`: see GraphMarginals.
  KeyframeMarginals(const PoseGraph& graph, const std::vector<KeyframeErrors>& errors,
                    const std::vector<double>& edge_weights);

  /// The pose first_T_keyframe, where `first` began the map. The error of the keyframe's match is
  /// to be added.
  std::optional<GaussianPose2> between(std::size_t first, std::size_t keyframe) const;

 private:
  std::vector<KeyframeErrors> errors_;
  std::vector<Eigen::Matrix3d> edges_;  // covariances of their errors
  GraphMarginals marginals_;
};

}  // namespace kestrel
