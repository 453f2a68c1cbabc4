// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "hybrid_matcher.h"

namespace kestrel {
namespace {

/// Angular size of the search window if the gyro gives the yaw, rad.
constexpr double kKnownYawWindow = 0.1;
/// A pose at this distance from the prior, in standard deviations, must have a score that is higher
/// by kPriorPenalty.
constexpr double kPlausibleChi2 = 9.0, kPriorPenalty = 0.035;

/// The window of three standard deviations, and of some cells and angular steps.
SearchWindow windowOf(const MotionPrior& prior) {
  constexpr double kLeastM = 0.15, kLeastRad = 0.05;
  const double sigmas = std::sqrt(kPlausibleChi2);
  return {std::max(kLeastM, sigmas * prior.sigma_m), std::max(kLeastRad, sigmas * prior.sigma_rad)};
}

}  // namespace

double MotionPrior::chi2(const Pose2& other) const {
  const Eigen::Vector3d offset = offsetBetween(pose, other);
  return offset.head<2>().squaredNorm() / (sigma_m * sigma_m) +
         offset.z() * offset.z() / (sigma_rad * sigma_rad);
}

bool MotionPrior::isPlausible(const Pose2& other) const { return chi2(other) <= kPlausibleChi2; }

bool isJump(const MatchRequest& request, const Pose2& pose) {
  if (request.prior) return !request.prior->isPlausible(pose);
  return (request.initial_guesses.front().inverse() * pose).distance() > request.plausible_m;
}

Pose2 searchCenter(const MatchRequest& request) {
  const Pose2& last = request.last;
  return {last.x, last.y, request.yaw_known ? request.initial_guesses.front().yaw : last.yaw};
}

std::vector<SearchWindow> searchWindows(const MatcherConfig& config, const MatchRequest& request) {
  std::vector<SearchWindow> windows = {config.near_window, config.wide_window};
  if (request.prior && !request.lost) {
    windows.insert(windows.begin(), windowOf(*request.prior));
    return windows;
  }
  if (request.search_all_yaws) windows.push_back({config.wide_window.linear_m, kPi});
  for (SearchWindow& window : windows) {
    window.linear_m *= request.search_scale;
    if (!request.yaw_known) continue;
    window.angular_rad =
        std::min(window.angular_rad, std::max(kKnownYawWindow, request.yaw_error_rad));
  }
  return windows;
}

double jumpMargin(const MatcherConfig& config, const MatchRequest& request, const Pose2& pose) {
  if (request.prior || request.wide) return 0.0;
  const Pose2 jump = request.initial_guesses.front().inverse() * pose;
  const double ratio = std::max(1.0, jump.distance() / request.plausible_m);
  return config.jump_margin * ratio * ratio;
}

CorrelativeConfig preferencesFor(const MatchRequest& request, const CorrelativeConfig& config) {
  CorrelativeConfig result = config;
  result.linear_preference /= request.moved_scale;
  result.angular_preference /= request.moved_scale;
  return result;
}

double penalizedScore(const MatchRequest& request, const Fit& fit, const Pose2& pose,
                      const CorrelativeConfig& preferences) {
  // The logarithm leaves a chance to a slip of the wheels, if the scan fits much better there.
  if (request.prior)
    return fit.score - kPriorPenalty * std::log2(1.0 + request.prior->chi2(pose) / kPlausibleChi2);
  const CorrelativeConfig config = preferencesFor(request, preferences);
  const Pose2 motion = request.last.inverse() * pose;
  return fit.score - config.linear_preference * motion.distance() -
         config.angular_preference * std::abs(motion.yaw);
}

}  // namespace kestrel
