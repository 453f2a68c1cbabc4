// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_sign.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// A difference of so many standard deviations is no error.
constexpr double kClearSigmas = 3.0;
/// Standard deviation of the matches at both ends of a motion, m.
constexpr double kMatchErrorM = 0.015;
/// Distance of the base frame from the point about which the vehicle turns.
constexpr double kLeverM = 0.2;
/// A run ends after this distance or rotation. One that turns more says nothing: after a turn the
/// vehicle is behind where it was without driving back.
constexpr double kRunM = 0.3, kRunRad = 0.5, kMostTurnRad = 1.5;

/// Standard deviation of the difference between a motion and its match, m.
double sigmaOf(double error_m, double turn_rad) {
  return std::hypot(error_m, kMatchErrorM, kLeverM * turn_rad);
}

double distanceBetween(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm();
}

/// Whether a motion and its reverse are so far apart that a match tells which one it was.
bool isClear(const Pose2& measured, double error_m) {
  return 2.0 * measured.distance() > kClearSigmas * sigmaOf(error_m, measured.yaw);
}

/// Whether the match is nearer to the reverse of what was measured.
bool isAgainst(const Pose2& measured, const Pose2& matched) {
  return distanceBetween(matched, reversed(measured)) < distanceBetween(matched, measured);
}

}  // namespace

/// With a uniform prior.
double OdometrySign::chance(bool is_reversed) const {
  const std::array<int, 2>& after_last = motions_[last_ ? 1 : 0];
  return (after_last[is_reversed ? 1 : 0] + 1.0) / (after_last[0] + after_last[1] + 2.0);
}

double OdometrySign::wrongShare() const {
  return isMissing() ? std::min(chance(true), chance(false)) : 0.0;
}

bool OdometrySign::isReversed(const Pose2& measured, const Pose2& matched, double error_m) const {
  if (!isMissing()) return false;
  return isClear(measured, error_m) ? isAgainst(measured, matched) : isReversedNext();
}

void OdometrySign::follow(const Pose2& measured, const Pose2& matched, double error_m) {
  if (!isClear(measured, error_m)) return;
  const bool is_reversed = isAgainst(measured, matched);
  ++motions_[last_ ? 1 : 0][is_reversed ? 1 : 0];
  last_ = is_reversed;
}

void OdometrySign::learn(const Pose2& measured, const Pose2& matched, double error_m) {
  run_.measured = run_.measured * measured;
  run_.matched = run_.matched * matched;
  run_.path_m += measured.distance();
  run_.turn_rad += std::abs(measured.yaw);
  run_.error_m += error_m;
  if (run_.path_m < kRunM && run_.turn_rad < kRunRad) return;
  learnRun();
  interrupt();
}

void OdometrySign::learnRun() {
  if (run_.turn_rad > kMostTurnRad) return;
  const double most = kClearSigmas * sigmaOf(run_.error_m, run_.turn_rad);
  const bool agrees = distanceBetween(run_.matched, run_.measured) <= most;
  const bool is_against = distanceBetween(run_.matched, reversed(run_.measured)) <= most;
  if (run_.measured.x < 0.0 && agrees && !is_against) ++for_;
  if (run_.measured.x > 0.0 && is_against && !agrees) ++against_;
}

std::optional<Pose2> SignedOdometry::next(const std::optional<Pose2>& odom_T_base,
                                          bool is_reversed) {
  if (odom_T_base && last_ && is_reversed) {
    const Pose2 before = signed_T_odom_ ? *signed_T_odom_ * *last_ : *last_;
    signed_T_odom_ = before * reversed(last_->between(*odom_T_base)) * odom_T_base->inverse();
  }
  last_ = odom_T_base;
  return odom_T_base && signed_T_odom_ ? *signed_T_odom_ * *odom_T_base : odom_T_base;
}

}  // namespace kestrel
