// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/graph_correction.h"

#include <utility>

namespace kestrel {

MapperResult GraphCorrection::inMap(MapperResult result) const {
  result.covariance = covarianceOf(result.uncertain);
  result.pose = map_T_local * result.pose;
  result.match.pose = map_T_local * result.match.pose;
  result.match.degenerate_direction = map_T_local.rotation() * result.match.degenerate_direction;
  result.match.covariance = rotated(result.match.covariance, map_T_local.yaw);
  result.uncertain = placedAt(result.pose, result.uncertain);
  if (!located) noteUnlocated(result);
  return result;
}

void noteUnlocated(MapperResult& result) {
  if (result.state == MatchState::kLost) return;
  result.state = MatchState::kDegraded;
  result.reason = "place unknown";
}

/// Of (x, y, yaw) in map: the error of the keyframe, and of the motion since then.
Eigen::Matrix3d GraphCorrection::covarianceOf(const UncertainPose& local) const {
  if (!known) return rotated(local.covariance(), map_T_local.yaw);
  const Pose2 motion = known->local.pose.between(local.pose);
  const GaussianPose2 moved{motion,
                            tangentCovariance(relativeCovariance(known->local, local), motion)};
  const GaussianPose2 pose = compose(known->map_T_keyframe, moved);
  return mapCovariance(pose.covariance, pose.mean);
}

}  // namespace kestrel
