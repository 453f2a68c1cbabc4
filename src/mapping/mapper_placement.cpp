// SPDX-License-Identifier: BSD-3-Clause
// What others tell the mapper: where the vehicle is, and how it moves.
#include <algorithm>

#include "mapper_state.h"

namespace kestrel {

void Mapper::setPose(const Pose2& map_T_base) {
  if (!isUsable(map_T_base)) return;
  state_->motion.setPose(map_T_base);
  state_->laser_odometry.stop();
  state_->motion_check.clear();
  state_->inertia.reset();
  state_->unsettled_scans = 0;
  state_->doubt.reset();
}

void Mapper::setFoundPose(const Pose2& map_T_base, const Mapper& measured) {
  if (!isUsable(map_T_base)) return;
  MotionModel motion = measured.state_->motion;
  setPose(map_T_base);
  motion.setFound(map_T_base);
  motion.takeInterval(state_->motion);
  state_->motion = motion;
  state_->uncertainty.setSpeedError(measured.state_->uncertainty.speedError());
}

void Mapper::takeMotion(const Mapper& before, const PlanarScan& scan,
                        const std::optional<Pose2>& odom_T_base) {
  const State& last = *before.state_;
  state_->motion.takeMotion(last.motion);
  state_->uncertainty.setSpeedError(
      std::max(last.uncertainty.speedError(), last.motion.errorAt(scan, odom_T_base).speed_m_s()));
}

void Mapper::takeInterval(const Mapper& other) {
  state_->motion.takeInterval(other.state_->motion);
}

void Mapper::learnInterval(double seconds) { state_->motion.learnInterval(seconds); }

bool Mapper::isAfterGap(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const {
  return state_->motion.isAfterGap(scan, odom_T_base);
}

double Mapper::reach(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base) const {
  return state_->motion.reach(scan, odom_T_base);
}

}  // namespace kestrel
