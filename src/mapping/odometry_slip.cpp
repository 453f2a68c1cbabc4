// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_slip.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/mapping/odometry_sign.h"
#include "kestrel_slam/matching/ambiguity.h"
#include "kestrel_slam/matching/place_match.h"

namespace kestrel {
namespace {

constexpr std::int64_t kSlipWork = 5'000'000;  // see WorkBudget
constexpr double kReachSigmas = 3.0;
/// Half of the scan must be in known space: less fits at many places.
constexpr double kLeastKnownShare = 0.5;

}  // namespace

FitAfterSlip matchAfterSlip(const Submap& map, const MatchRequest& request, const Pose2& last,
                            const MatchResult& found, const MatcherConfig& config,
                            const SlipKind& kind) {
  if (!request.prior || request.lost) return {};
  const MotionPrior& prior = *request.prior;
  const double reach = last.between(prior.pose).distance() + kReachSigmas * prior.sigma_m;
  const double turn = std::max(config.near_window.angular_rad, kReachSigmas * prior.sigma_rad);
  const PlaceMatch place = matchPlace(map, request.points, {last.x, last.y, prior.pose.yaw},
                                      {reach, turn}, config, kSlipWork);
  const MatchResult& match = place.match;
  const MotionPrior back{last * reversed(last.between(prior.pose)), prior.sigma_m, prior.sigma_rad};
  const bool is_reverse =
      kind.reverse && back.isPlausible(match.pose) && !prior.isPlausible(back.pose);
  const bool fits = (is_reverse || (kind.any && match.score >= config.search_score)) &&
                    match.known >= kLeastKnownShare;
  const bool reachable = last.between(match.pose).distance() <= reach;
  // The best other pose may also be the one that was found before.
  const bool is_same = isSamePlace(match, found.pose);
  const double found_score = found.score * found.known;
  const double second = is_same ? place.second_score : std::max(place.second_score, found_score);
  const bool is_clear = place.complete && place.score >= second + kClearlyBetter;
  FitAfterSlip result;
  const bool is_other = !is_same || is_reverse || place.score >= found_score + kClearlyBetter;
  if (fits && reachable && is_clear && !match.degenerate && is_other) result.match = match;
  result.is_reverse = is_reverse;
  result.ambiguous = !is_clear;
  return result;
}

}  // namespace kestrel
