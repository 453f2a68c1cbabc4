// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/prediction_error.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/match_result.h"
#include "kestrel_slam/matching/weak_motion.h"

namespace kestrel {

/// Whether the motion prediction is better than the match along the degenerate direction. Without a
/// motion sensor the little that the scan shows is used: otherwise a scan may be inserted with an
/// error of centimeters, and loops of whole buildings do not close.
inline bool isUnobservable(const MatchResult& match, PredictionSource source) {
  constexpr double kNoConstraint = 0.0035;  // share of the beams
  return match.degenerate &&
         (source != PredictionSource::kVelocity || match.constraint < kNoConstraint);
}

inline WeakMotion weakMotionOf(const MatchResult& match) {
  return {match.degenerate_direction, match.degenerate_turn, match.constraint};
}

/// Replaces the match along the unobservable direction by the motion prediction. There the match
/// only shows the discretization error of the cells.
inline void keepPredictionAlong(const Pose2& motion_prediction, MatchResult& match) {
  const Eigen::Vector2d missing = motion_prediction.translation() - match.pose.translation();
  match.pose = weakMotionOf(match).moved(match.pose, match.degenerate_direction.dot(missing));
}

/// Corrects the predicted position along the unobservable direction by the few beams that show it.
/// `variance`: of the prediction, m².
inline void correctAlong(const AlongFit& fit, double variance, double seconds, MatchResult& match) {
  // The scans of this time see the same noise of the map, so their errors do not average out.
  constexpr double kCorrelationTime = 0.25;  // s
  const double correlated =
      fit.variance_m2 * std::max(1.0, kCorrelationTime / std::max(seconds, 1e-3));
  // What differs more than both errors explain is not what the map shows, but floor or people.
  match.along_variance = std::max(correlated, fit.distance_m * fit.distance_m - variance);
  const double gain = variance / (variance + match.along_variance);
  match.pose = weakMotionOf(match).moved(match.pose, gain * fit.distance_m);
}

}  // namespace kestrel
