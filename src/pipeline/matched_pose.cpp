// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/matched_pose.h"

#include <cmath>

namespace kestrel {

MatchedPose matchedPoseOf(const MapperResult& result, double stamp) {
  // A predicted pose is no measurement, even if the vehicle is not lost.
  const MatchState state = result.isMatched() ? result.state : MatchState::kLost;
  MatchedPose pose{stamp, result.pose, result.covariance, result.velocity, state};
  const bool shown = result.match.predicted_along && std::isfinite(result.match.along_variance);
  if (result.match.degenerate && !shown) pose.unobservable = result.match.degenerate_direction;
  return pose;
}

Eigen::Vector2d knownVelocity(const MapperResult& result) {
  if (!result.isMatched()) return Eigen::Vector2d::Zero();
  return result.velocity;
}

double knownYawRate(const MapperResult& result) {
  return result.isMatched() ? result.yaw_rate : 0.0;
}

bool fuse(const MatchedPose& pose, PoseFilter& filter) {
  if (pose.state == MatchState::kLost) return false;
  return filter.addPose({pose.stamp, pose.pose, pose.covariance, pose.unobservable});
}

}  // namespace kestrel
