// SPDX-License-Identifier: BSD-3-Clause
#include "unobservable_motion.h"

#include <algorithm>

namespace kestrel {

bool isUnobservable(const MatchResult& match, PredictionSource source) {
  constexpr double kNoConstraint = 0.0035;  // share of the beams
  return match.degenerate &&
         (source != PredictionSource::kVelocity || match.constraint < kNoConstraint);
}

WeakMotion weakMotionOf(const MatchResult& match) {
  return {match.degenerate_direction, match.degenerate_turn, match.constraint};
}

void keepPredictionAlong(const Pose2& motion_prediction, MatchResult& match) {
  const Eigen::Vector2d missing = motion_prediction.translation() - match.pose.translation();
  match.pose = weakMotionOf(match).moved(match.pose, match.degenerate_direction.dot(missing));
}

void correctAlong(const AlongFit& fit, double variance, double seconds, MatchResult& match) {
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
