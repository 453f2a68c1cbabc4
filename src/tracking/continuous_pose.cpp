// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/continuous_pose.h"

#include <cmath>

namespace kestrel {

namespace {

/// A search that corrects the motion by less than this, in m and rad, found what the laser saw. A
/// wrong prediction would harm more.
constexpr double kLargestCorrection = 0.2;

bool isJump(const Pose2& correction) {
  return correction.distance() > kLargestCorrection ||
         std::abs(correction.yaw) > kLargestCorrection;
}

}  // namespace

Pose2 ContinuousPose::add(double time, const Pose2& map_T_base, bool may_jump,
                          const std::optional<Pose2>& odom_T_base) {
  if (!last_) {
    pose_ = map_T_base;
  } else {
    const double seconds = time - last_->time;
    Pose2 step = last_->map_T_base.inverse() * map_T_base;
    const Pose2 expected = odom_T_base && last_->odom_T_base
                               ? last_->odom_T_base->inverse() * *odom_T_base
                               : Pose2::exp(seconds * velocity_);
    if (may_jump && isJump(expected.inverse() * step)) {
      step = expected;
    } else if (seconds > 0.0) {
      velocity_ = step.log() / seconds;
    }
    pose_ = pose_ * step;
  }
  last_ = Last{time, map_T_base, odom_T_base};
  return pose_;
}

}  // namespace kestrel
