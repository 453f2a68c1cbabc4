// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/matched_pose.h"

namespace kestrel {

MatchedPose matchedPoseOf(const MapperResult& result, double stamp) {
  MatchedPose pose{stamp, result.pose, result.covariance, result.velocity, result.state};
  if (result.match.degenerate) pose.unobservable = result.match.degenerate_direction;
  return pose;
}

bool fuse(const MatchedPose& pose, PoseFilter& filter) {
  if (pose.state == MatchState::kLost) return false;
  return filter.addPose({pose.stamp, pose.pose, pose.covariance, pose.unobservable});
}

}  // namespace kestrel
