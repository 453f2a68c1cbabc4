// SPDX-License-Identifier: BSD-3-Clause
// The part of MotionModel that uses the odometry.
#include <cmath>

#include "kestrel_slam/mapping/motion_model.h"

namespace kestrel {
namespace {

/// The errors of the matches at both ends of a motion by the odometry.
constexpr double kPriorM = 0.02, kPriorRad = 0.01;

}  // namespace

/// Whether the match may not find the pose without odometry.
bool MotionModel::needsOdometry(const PlanarScan& scan) const {
  return lost_scans_ > 0 || carried_ || isWide(errorAt(scan, std::nullopt));
}

/// The pose by the odometry. Nothing if a pose filter knows better, or if the odometry did not
/// measure the last motion.
std::optional<MotionPrior> MotionModel::priorAt(const std::optional<Pose2>& odom_T_base,
                                                const PredictionError& error,
                                                const PlanarScan& scan) const {
  if (placed_ || filterMotionSince(scan) || !needsOdometry(scan)) return std::nullopt;
  const std::optional<Pose2> moved = odometryMotion(odom_T_base);
  if (!moved) return std::nullopt;
  return MotionPrior{pose_ * *moved, std::hypot(error.position_m(), kPriorM),
                     std::hypot(error.yaw_rad(), kPriorRad)};
}

std::optional<Pose2> MotionModel::odometryMotion(const std::optional<Pose2>& odom_T_base) const {
  if (!odom_ || !odom_T_base) return std::nullopt;
  return odometry_.corrected(odom_->inverse() * *odom_T_base);
}

void MotionModel::learnOdometry(const Pose2& found, const std::optional<Pose2>& odom_T_base,
                                bool well_matched) {
  const bool since_last = last_well_matched_ && odom_ && odom_T_base && !placed_;
  if (well_matched && since_last) {
    odometry_.learn(odom_->inverse() * *odom_T_base, pose_.inverse() * found);
  } else {
    odometry_.interrupt();
  }
  last_well_matched_ = well_matched;
}

}  // namespace kestrel
