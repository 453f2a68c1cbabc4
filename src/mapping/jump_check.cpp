// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/jump_check.h"

#include <cmath>

namespace kestrel {
namespace {

/// A pose farther from the prediction than this, and than so many standard deviations, is a jump.
constexpr double kJumpM = 0.1, kJumpRad = 0.03, kJumpSigmas = 5.0;
/// Jumps agree if they differ by less than this.
constexpr double kSameM = 0.05, kSameRad = 0.015;
constexpr int kAgreeingScans = 3;

}  // namespace

bool JumpCheck::isJump(const Pose2& predicted, const Pose2& found, const PredictionError& error) {
  const Pose2 jump = predicted.between(found);
  return jump.distance() > kJumpM + kJumpSigmas * error.position_m() ||
         std::abs(jump.yaw) > kJumpRad + kJumpSigmas * error.yaw_rad();
}

bool JumpCheck::accepts(const Pose2& predicted, const Pose2& found, const PredictionError& error) {
  if (!isJump(predicted, found, error)) {
    agreeing_ = 0;
    return true;
  }
  const Pose2 jump = predicted.between(found);
  const Pose2 change = jump_.between(jump);
  const bool same = change.distance() < kSameM && std::abs(change.yaw) < kSameRad;
  agreeing_ = agreeing_ > 0 && same ? agreeing_ + 1 : 1;
  jump_ = jump;
  if (agreeing_ < kAgreeingScans) return false;
  agreeing_ = 0;
  return true;
}

}  // namespace kestrel
