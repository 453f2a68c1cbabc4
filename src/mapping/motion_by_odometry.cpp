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

PredictionError MotionModel::errorAt(const PlanarScan& scan,
                                     const std::optional<Pose2>& odom_T_base) const {
  const std::optional<Pose2> measured = measuredMotion(odom_T_base);
  return errorAt(scan, odom_T_base, measured ? odometry_.errorOf(*measured) : MotionError());
}

/// The pose by the odometry. Nothing if a pose filter knows better, or if the odometry did not
/// measure the last motion.
std::optional<MotionPrior> MotionModel::priorAt(const std::optional<Pose2>& odom_T_base,
                                                const PlanarScan& scan) const {
  if (placed_ || filterMotionSince(scan) || !needsOdometry(scan)) return std::nullopt;
  const std::optional<Pose2> moved = odometryMotion(odom_T_base);
  if (!moved) return std::nullopt;
  // In the other direction it is searched for elsewhere, see matchAfterSlip.
  const PredictionError error =
      errorAt(scan, odom_T_base, odometry_.errorAlongDirection(*measuredMotion(odom_T_base)));
  return MotionPrior{pose_ * *moved, std::hypot(error.position_m(), kPriorM),
                     std::hypot(error.yaw_rad(), kPriorRad)};
}

std::optional<Pose2> MotionModel::measuredMotion(const std::optional<Pose2>& odom_T_base) const {
  if (!odom_ || !odom_T_base) return std::nullopt;
  return odom_->inverse() * *odom_T_base;
}

std::optional<Pose2> MotionModel::odometryMotion(const std::optional<Pose2>& odom_T_base) const {
  const std::optional<Pose2> measured = measuredMotion(odom_T_base);
  return measured ? std::optional(odometry_.corrected(*measured)) : std::nullopt;
}

void MotionModel::learnOdometry(const Pose2& found, const std::optional<Pose2>& odom_T_base,
                                MatchWorth worth, bool on_way_back) {
  const std::optional<Pose2> measured = placed_ ? std::nullopt : measuredMotion(odom_T_base);
  const Pose2 matched = pose_.inverse() * found;
  const bool is_matched = measured && worth != MatchWorth::kNone;
  if (measured && last_match_is_clear_ && worth == MatchWorth::kClear) {
    odometry_.learn(*measured, matched);
  } else {
    odometry_.interrupt();
  }
  const bool is_known = odometry_.sign().isMissing();
  reversed_ = !is_known    ? is_matched && on_way_back
              : is_matched ? odometry_.isReversed(*measured, matched)
                           : odometry_.sign().isReversedNext();
  if (is_matched) odometry_.follow(*measured, matched);
  last_match_is_clear_ = worth == MatchWorth::kClear;
}

}  // namespace kestrel
