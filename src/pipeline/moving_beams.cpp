// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/moving_beams.h"

#include <algorithm>
#include <vector>

namespace kestrel {
namespace {

/// The free space ends this much before a return from something that moves, m: its other parts may
/// be nearer.
constexpr float kFreeBefore = 0.3F;

void clearOnly(PlanarRay& ray) {
  const Eigen::Vector2f along = ray.end - ray.origin;
  const float range = along.norm();
  ray.hit = false;
  ray.end =
      range > kFreeBefore ? (ray.origin + (1.0F - kFreeBefore / range) * along).eval() : ray.origin;
}

}  // namespace

void MovingBeams::keepOut(PlanarScan& scan) const {
  const std::vector<bool> moving = tracker_.expectMoving(scan, continuous_.predict(scan.time));
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    if (moving[i]) clearOnly(scan.rays[i]);
  }
}

void MovingBeams::add(const PlanarScan& scan, const MapperResult& result,
                      const std::optional<Pose2>& odom_T_base) {
  const bool may_jump = result.searched || result.state == MatchState::kLost;
  pose_ = continuous_.add(scan.time, result.pose, may_jump, odom_T_base);
  tracker_.process(scan, pose_);
}

void MovingBeams::reset() {
  tracker_.reset();
  continuous_ = ContinuousPose();
}

}  // namespace kestrel
