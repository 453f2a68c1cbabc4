// SPDX-License-Identifier: BSD-3-Clause
#include "unobservable_motion.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/mapping/pose_uncertainty.h"

namespace kestrel {
namespace {

/// Largest standard deviation of a match that shows something along the weakest direction, m.
constexpr double kMostMatchSigma = 0.1;

/// The scans of some time see the same noise of the map, so their errors do not average out.
double correlated(double variance, double seconds) {
  constexpr double kCorrelationTime = 0.25;  // s
  return variance * std::max(1.0, kCorrelationTime / std::max(seconds, 1e-3));
}

}  // namespace

bool isWeak(const MatchResult& match, PredictionSource source) {
  return match.degenerate ||
         (source == PredictionSource::kVelocity && match.constraint < kWeakConstraint);
}

bool isUnobservable(const MatchResult& match, PredictionSource source) {
  constexpr double kNoConstraint = 0.0035;  // share of the beams
  return match.degenerate &&
         (source != PredictionSource::kVelocity || match.constraint < kNoConstraint);
}

Beams beamsOf(PredictionSource source) {
  return source == PredictionSource::kOdometry ? Beams::kAll : Beams::kCertain;
}

WeakMotion weakMotionOf(const MatchResult& match) {
  return {match.degenerate_direction, match.degenerate_turn, match.constraint};
}

void checkAlong(const Submap& map, const Points& points, double away_m, double sigma_m,
                MatchResult& match) {
  constexpr double kNoiseM = 0.03;  // of a match
  constexpr double kClearSigmas = 2.0;
  if (std::abs(away_m) <= kNoiseM + sigma_m) return;
  const double sigmas = evidenceAgainst(map, points, match.pose, weakMotionOf(match), away_m);
  if (sigmas >= kClearSigmas) return;
  match.unclear_along = true;
  const double other_is_right = 0.5 * std::erfc(sigmas / std::sqrt(2.0));
  const Eigen::Vector2d& along = match.degenerate_direction;
  match.covariance.topLeftCorner<2, 2>() +=
      other_is_right * away_m * away_m * along * along.transpose();
}

double keepPredictionAlong(const Pose2& motion_prediction, MatchResult& match) {
  const Eigen::Vector2d missing = motion_prediction.translation() - match.pose.translation();
  const double moved = match.degenerate_direction.dot(missing);
  match.pose = weakMotionOf(match).moved(match.pose, moved);
  return -moved;
}

AlongFit combined(const AlongFit& fit, double matched_m) {
  const double apart = matched_m - fit.distance_m;
  if (apart * apart > fit.variance_m2) return fit;
  return {matched_m, std::min(fit.variance_m2, kMostMatchSigma * kMostMatchSigma)};
}

void correctAlong(const AlongFit& fit, double variance, double seconds, MatchResult& match) {
  // What differs more than both errors explain is not what the map shows, but floor or people.
  match.along_variance =
      std::max(correlated(fit.variance_m2, seconds), fit.distance_m * fit.distance_m - variance);
  const double gain = variance / (variance + match.along_variance);
  match.pose = weakMotionOf(match).moved(match.pose, gain * fit.distance_m);
  match.predicted_along = true;
  match.mostly_predicted = gain < 0.5;
}

}  // namespace kestrel
