// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_slip.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/matching/ambiguity.h"
#include "kestrel_slam/matching/place_match.h"

namespace kestrel {
namespace {

constexpr std::int64_t kSlipWork = 5'000'000;  // see WorkBudget
constexpr double kReachSigmas = 3.0;
/// Half of the scan must be in known space: less fits at many places.
constexpr double kLeastKnownShare = 0.5;

}  // namespace

std::optional<MatchResult> matchAfterSlip(const Submap& map, const MatchRequest& request,
                                          const Pose2& last, const MatchResult& refused,
                                          const MatcherConfig& config) {
  if (!request.prior || request.lost) return std::nullopt;
  const MotionPrior& prior = *request.prior;
  const double reach = last.between(prior.pose).distance() + kReachSigmas * prior.sigma_m;
  const double turn = std::max(config.near_window.angular_rad, kReachSigmas * prior.sigma_rad);
  const PlaceMatch place = matchPlace(map, request.points, {last.x, last.y, prior.pose.yaw},
                                      {reach, turn}, config, kSlipWork);
  const MatchResult& match = place.match;
  const bool fits = match.score >= config.search_score && match.known >= kLeastKnownShare;
  // The best other pose may also be the one that was refused.
  const double second = std::max(place.second_score, refused.score * refused.known);
  const bool unique = place.complete && !match.degenerate && place.score >= second + kClearlyBetter;
  const bool reachable = last.between(match.pose).distance() <= reach;
  return fits && unique && reachable ? std::optional(match) : std::nullopt;
}

}  // namespace kestrel
