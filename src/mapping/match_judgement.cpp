// SPDX-License-Identifier: BSD-3-Clause
// The mapper's decision what a match is worth.
#include <algorithm>
#include <cmath>

#include "mapper_state.h"

namespace kestrel {
namespace {

/// A vehicle that was not matched is found if the scan fits well (search_score) and this share of
/// it is in known space; in a large window half of a scan fits at many places. Near the prediction
/// less is enough, above all if a part of the scan is in new space: the second score is that of a
/// scan in known space.
constexpr double kSureKnownShare = 0.5, kFoundScore = 0.5, kKnownFoundScore = 0.7,
                 kFoundKnownShare = 0.3;
constexpr double kFoundSigmas = 3.0;
/// After a lost or ambiguous pose, and after a gap in which the vehicle may have left the search
/// window, this many scans must fit before the state is ok.
constexpr int kSettlingScans = 10;
/// The few points that are farther away do not count in the reach of a scan.
constexpr double kNearlyAll = 0.9;

/// Whether nearly all points are nearer than `distance`, m.
bool reachLess(const Points& points, double distance) {
  const auto nearer = std::count_if(points.begin(), points.end(), [&](const Eigen::Vector2f& p) {
    return static_cast<double>(p.norm()) < distance;
  });
  return static_cast<double>(nearer) >= kNearlyAll * static_cast<double>(points.size());
}

}  // namespace

/// After a pose that may be wrong, the state is degraded until some scans in a row fit.
void Mapper::State::settle(bool out_of_reach, MapperResult& result) {
  if (out_of_reach) unsettled_scans = kSettlingScans;
  if (result.state == MatchState::kLost || result.match.ambiguous ||
      result.match.impossible_motion) {
    unsettled_scans = kSettlingScans;
  } else if (unsettled_scans > 0) {
    if (result.state == MatchState::kOk) --unsettled_scans;
    result.state = MatchState::kDegraded;
  }
  if (result.match.impossible_motion && !doubt) doubt.emplace();
  if (result.state == MatchState::kOk) doubt.reset();
  result.doubtful = doubt.has_value();
}

/// From where the error needs a wide window, the search finds the pose in that window: the error
/// does not grow any more.
void Mapper::State::growDoubt(const PlanarScan& scan) {
  if (!doubt || motion.isWide(*doubt)) return;
  PredictedStep step;
  step.seconds = motion.secondsSince(scan);
  step.yaw_measured = true;  // what moves is followed by the position; the walls show the yaw
  doubt->grow(step);
}

/// The walls that moved may have taken the pose along, farther than a descent finds back. So it is
/// searched for where the error is large, and before the doubt ends.
MatchResult Mapper::State::matchInDoubt(const MatchRequest& request) const {
  const bool is_searched =
      doubt && !request.lost && !request.prior && (motion.isWide(*doubt) || unsettled_scans <= 1);
  if (!is_searched) return matcher->match(map.current(), request);
  MatchRequest wide = request;
  wide.wide = true;
  wide.last = request.initial_guesses.front();
  return matcher->match(map.current(), wide);
}

void Mapper::State::compareWithInertia(const PlanarScan& scan, MatchResult& match) {
  const std::optional<Eigen::Vector2d> away = inertia.contradiction(scan, match.pose);
  inertia.learn(motion, scan, match.pose);
  if (!away) return;
  match.against_inertia = true;
  match.covariance.topLeftCorner<2, 2>() += *away * away->transpose();
}

void Mapper::State::updateInertia(const PlanarScan& scan, const MapperResult& result) {
  if (result.state == MatchState::kLost) {
    inertia.reset();
  } else if (result.match.against_inertia) {
    inertia.goOn(scan);
  } else {
    inertia.follow(motion);
  }
}

/// Whether more of the scan contradicts the map than it shows new space. In doubt such a scan would
/// only teach the map what moved, and the next one like it would fit.
bool Mapper::State::contradictsMap(const MatchResult& match) const {
  return match.known * (1.0 - match.score) > 1.0 - match.known;
}

/// A poor fit far from where the vehicle is predicted is worth less than the prediction.
bool Mapper::State::isLikely(const MatchResult& match, const MatchRequest& request,
                             const PredictionError& error) {
  const MatcherConfig& limits = config.matcher;
  const Pose2& predicted = request.initial_guesses.front();
  // A hand over the laser fits wherever a wall ends. What a scan shows must reach as far as the
  // jump that it is to explain.
  if (reachLess(request.points, predicted.between(match.pose).distance())) return false;
  if (request.prior) {
    return match.score >= limits.search_score || request.prior->isPlausible(match.pose);
  }
  const bool sure = match.score >= limits.search_score && match.known >= kSureKnownShare;
  if (!request.lost && !jumps.accepts(predicted, match.pose, error) && (few_hits || !sure))
    return false;
  if (!request.lost && !motion.isCarried()) return true;
  if (sure) return true;
  const Pose2 away = predicted.between(match.pose);
  const double least = kFoundScore + (kKnownFoundScore - kFoundScore) * match.known;
  return match.score >= least && match.known >= kFoundKnownShare &&
         away.distance() <= kFoundSigmas * error.position_m() &&
         std::abs(away.yaw) <= kFoundSigmas * error.yaw_rad();
}

MatchState Mapper::State::judge(const MatchResult& match, const MatchRequest& request,
                                const PredictionError& error) {
  if (match.score < config.lost_score || match.known < config.min_known_share ||
      !isLikely(match, request, error))
    return MatchState::kLost;
  const bool clear = !match.degenerate && !match.mostly_predicted && !match.unclear_along &&
                     !match.against_inertia && !match.ambiguous;
  const bool good = match.score >= config.matcher.search_score && clear;
  return good && !match.impossible_motion ? MatchState::kOk : MatchState::kDegraded;
}

}  // namespace kestrel
