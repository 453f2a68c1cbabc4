// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/match_reason.h"

namespace kestrel {
namespace {

const char* reasonOfCarried(const MapperResult& result, const MapperConfig& config) {
  if (result.blank) return "carried: few hits";
  if (result.match.ambiguous) return "carried: ambiguous";
  return result.match.known < config.min_known_share ? "carried: new space" : "carried: no fit";
}

const char* reasonOfLost(const MapperResult& result, const MapperConfig& config) {
  if (config.known_poses) return "no known pose";
  if (result.blank) return "few hits";
  if (result.match.ambiguous) return "ambiguous";
  if (result.match.incomplete) return "search not finished";
  return result.match.known < config.min_known_share ? "new space" : "no fit";
}

const char* reasonOfDegraded(const MapperResult& result, const MapperConfig& config) {
  if (result.match.ambiguous) return "ambiguous";
  if (result.match.impossible_motion) return "impossible motion";
  if (result.match.degenerate || result.match.mostly_predicted) return "direction unobservable";
  if (result.match.unclear_along) return "direction unclear";
  if (result.match.against_inertia) return "IMU disagrees";
  // A scan that fits is degraded only for some time after a pose that may be wrong.
  return result.match.score < config.matcher.search_score ? "poor fit" : "settling";
}

}  // namespace

const char* toString(MatchState state) {
  switch (state) {
    case MatchState::kOk:
      return "ok";
    case MatchState::kDegraded:
      return "degraded";
    case MatchState::kLost:
      return "lost";
  }
  return "unknown";
}

const char* reasonOf(const MapperResult& result, const MapperConfig& config) {
  if (result.state == MatchState::kOk) return "fits";
  if (result.state == MatchState::kLost) return reasonOfLost(result, config);
  return result.carried ? reasonOfCarried(result, config) : reasonOfDegraded(result, config);
}

}  // namespace kestrel
