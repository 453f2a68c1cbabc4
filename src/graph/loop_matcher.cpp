// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/loop_matcher.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/symmetric_axes.h"
#include "kestrel_slam/graph/wall_agreement.h"
#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Work of one search, see WorkBudget.
constexpr std::int64_t kLoopWork = 10'000'000;
/// Number of points of a query, and of a single scan.
constexpr std::size_t kQueryPoints = 1000, kLoopScanPoints = 360;
/// The errors of a match with an old place: those of the place's own walls, which neighboring
/// matches have in common.
constexpr double kLoopPlaceM = 0.015, kLoopPlaceRad = 0.004, kLoopMatchFactor = 4.0;
/// A single scan agrees if it fits at the same place up to this.
constexpr double kSameLoopM = 0.15, kSameLoopRad = 0.035, kSingleLoopFit = 0.6, kSingleKnown = 0.4;
/// Beams of a query whose walls are compared with those of the place.
constexpr std::size_t kWallBeams = 4000;
/// A scan with fewer hits says nothing.
constexpr std::size_t kLeastLoopHits = 10;
/// Limits where the graph already expects the place.
constexpr double kExpectedFit = 0.75, kExpectedRad = 0.1;
constexpr const char* kContradicted = "its walls contradict the place";

Points pointsOf(const std::vector<LocalKeyframe>& keyframes, const LoopQuery& query) {
  const Pose2 middle_T_local = keyframes[query.middle()].local_T_base.inverse();
  Points result;
  for (std::size_t i = query.first; i < query.last; ++i) {
    const Pose2 middle_T_base = middle_T_local * keyframes[i].local_T_base;
    for (const Eigen::Vector2f& hit : keyframes[i].keyframe->scan.hits())
      result.push_back((middle_T_base * hit.cast<double>()).cast<float>());
  }
  return sampled(result, kQueryPoints);
}

std::size_t nearestKeyframe(const KnownPlace& place, const std::vector<LocalKeyframe>& keyframes,
                            const Pose2& local_T_base) {
  std::size_t nearest = place.first;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = place.first; i < place.last; ++i) {
    const double distance = keyframes[i].local_T_base.between(local_T_base).distance();
    if (distance < least) least = distance, nearest = i;
  }
  return nearest;
}

/// Covariance of the match. If only a few points show the weakest direction, one moved object among
/// them has a large effect: the loop then gives little information about this direction.
Eigen::Matrix3d covarianceOf(const MatchResult& match, double min_constraint) {
  constexpr double kLeastConstraint = 1e-3;
  Eigen::Matrix3d result = kLoopMatchFactor * match.covariance;
  const double constraint = std::max(match.constraint, kLeastConstraint);
  if (constraint >= min_constraint) return result;
  const SymmetricAxes<2> axes = symmetricAxes(Eigen::Matrix2d(result.topLeftCorner<2, 2>()));
  const Eigen::Vector2d weakest =
      axes.eigenvectors.col(1) * kLoopPlaceM * min_constraint / constraint;
  result.topLeftCorner<2, 2>() += weakest * weakest.transpose();
  return result;
}

/// The walls of the query and of the place, if the middle keyframe is at `local_T_found`.
WallAgreement wallsAt(const Submap& map, const std::vector<LocalKeyframe>& keyframes,
                      const LoopQuery& query, const Pose2& local_T_found) {
  const Pose2 found_T_local = local_T_found * keyframes[query.middle()].local_T_base.inverse();
  std::vector<PlanarScan> scans(query.last - query.first);
  std::vector<ScanInMap> placed;
  for (std::size_t i = query.first; i < query.last; ++i) {
    PlanarScan& scan = scans[i - query.first];
    scan.rays = keyframes[i].keyframe->scan.rays();
    placed.push_back({found_T_local * keyframes[i].local_T_base, &scan});
  }
  return compareWalls(map, placed, kWallBeams);
}

/// `away` without the part along an unobservable direction.
Eigen::Vector2d observable(const Eigen::Vector2d& away, const MatchResult& match) {
  if (!match.degenerate) return away;
  return away - match.degenerate_direction * match.degenerate_direction.dot(away);
}

}  // namespace

const char* toString(LoopState state) {
  switch (state) {
    case LoopState::kAccepted:
      return "accepted";
    case LoopState::kPending:
      return "pending";
    case LoopState::kRefused:
      return "refused";
    case LoopState::kUndone:
      return "undone";
  }
  return "unknown";
}

PoseEdge graphEdgeOf(const Loop& loop) {
  return {loop.anchor, loop.query, loop.anchor_T_query.mean,
          loop.anchor_T_query.covariance.inverse(), EdgeKind::kLoop};
}

Loop LoopMatcher::loopAt(const KnownPlace& place, const std::vector<LocalKeyframe>& keyframes,
                         std::size_t query, const MatchResult& match) const {
  Loop loop;
  loop.anchor = nearestKeyframe(place, keyframes, match.pose);
  loop.query = query;
  loop.anchor_T_query.mean = keyframes[loop.anchor].local_T_base.between(match.pose);
  loop.anchor_T_query.covariance =
      tangentCovariance(covarianceOf(match, config_.min_constraint), match.pose);
  loop.anchor_T_query.covariance.diagonal() +=
      Eigen::Vector3d(kLoopPlaceM, kLoopPlaceM, kLoopPlaceRad).cwiseAbs2();
  loop.fit = match.score;
  loop.known = match.known;
  loop.constraint = match.constraint;
  return loop;
}

const char* LoopMatcher::problemOf(const Loop& loop) const {
  if (loop.fit < config_.min_fit) return "it does not fit";
  if (loop.known < config_.min_known) return "too little of it is known";
  if (loop.constraint < matcher_.degenerate_share) return "a direction is unobservable";
  if (loop.margin < config_.min_margin) return "it fits in several places";
  if (loop.correction_m > loop.radius_m) return "it is too far away";
  return "";
}

Loop LoopMatcher::search(const Submap& map, const KnownPlace& place,
                         const std::vector<LocalKeyframe>& keyframes, const LoopQuery& query,
                         const Pose2& expected, double radius_m, double yaw_rad) const {
  const SearchWindow window{std::max(radius_m, config_.wide_radius_m), yaw_rad};
  const PlaceMatch found =
      matchPlace(map, pointsOf(keyframes, query), expected, window, matcher_, kLoopWork);
  Loop loop = loopAt(place, keyframes, query.middle(), found.match);
  loop.margin = found.complete ? found.score - found.second_score : 0.0;
  loop.radius_m = radius_m;
  loop.correction_m = expected.between(found.match.pose).distance();
  loop.reason = problemOf(loop);
  if (!loop.reason.empty()) return loop;
  loop.agreement = agreementAt(map, keyframes, query, found.match);
  if (loop.agreement < config_.min_agreement) {
    loop.reason = "its scans do not agree";
  } else if (contradicts(map, keyframes, query, found.match.pose)) {
    loop.reason = kContradicted;
  } else {
    loop.state = LoopState::kPending;
  }
  return loop;
}

Loop LoopMatcher::matchExpected(const Submap& map, const KnownPlace& place,
                                const std::vector<LocalKeyframe>& keyframes, std::size_t keyframe,
                                const Pose2& expected, double radius_m) const {
  const Points points = sampled(keyframes[keyframe].keyframe->scan.hits(), kLoopScanPoints);
  Loop none;
  none.anchor = place.first;
  none.query = keyframe;
  none.reason = "too few hits";
  if (points.size() < kLeastLoopHits) return none;
  const MatchResult match = matchNear(map, points, expected, matcher_);
  Loop loop = loopAt(place, keyframes, keyframe, match);
  const Pose2 correction = expected.between(match.pose);
  loop.correction_m = correction.distance();
  if (loop.fit < kExpectedFit) {
    loop.reason = "it does not fit";
  } else if (loop.known < config_.min_known) {
    loop.reason = "too little of it is known";
  } else if (loop.constraint < matcher_.degenerate_share) {
    loop.reason = "a direction is unobservable";
  } else if (loop.correction_m > radius_m || std::abs(correction.yaw) > kExpectedRad) {
    loop.reason = "it is too far away";
  } else if (contradicts(map, keyframes, {keyframe, keyframe + 1}, match.pose)) {
    loop.reason = kContradicted;
  } else {
    loop.state = LoopState::kAccepted;
  }
  return loop;
}

/// Whether the walls of the query contradict those of the place, if the middle keyframe is at
/// `local_T_found`.
bool LoopMatcher::contradicts(const Submap& map, const std::vector<LocalKeyframe>& keyframes,
                              const LoopQuery& query, const Pose2& local_T_found) const {
  return wallsAt(map, keyframes, query, local_T_found).possibleContradiction() >
         config_.max_contradiction;
}

/// The share of the single scans that fit where the whole query fits.
double LoopMatcher::agreementAt(const Submap& map, const std::vector<LocalKeyframe>& keyframes,
                                const LoopQuery& query, const MatchResult& found) const {
  int agreeing = 0, all = 0;
  const Pose2& local_T_middle = keyframes[query.middle()].local_T_base;
  for (std::size_t i = query.first; i < query.last; ++i) {
    const Points points = sampled(keyframes[i].keyframe->scan.hits(), kLoopScanPoints);
    if (points.size() < kLeastLoopHits) continue;
    const Pose2 expected = found.pose * local_T_middle.between(keyframes[i].local_T_base);
    ++all;
    if (agrees(matchNear(map, points, expected, matcher_), expected, found)) ++agreeing;
  }
  return all == 0 ? 0.0 : static_cast<double>(agreeing) / all;
}

bool LoopMatcher::agrees(const MatchResult& single, const Pose2& expected,
                         const MatchResult& found) const {
  if (single.score < kSingleLoopFit || single.known < kSingleKnown) return false;
  const Eigen::Vector2d away =
      observable(observable(single.pose.translation() - expected.translation(), single), found);
  return away.norm() < kSameLoopM &&
         std::abs(normalizeAngle(single.pose.yaw - expected.yaw)) < kSameLoopRad;
}

}  // namespace kestrel
