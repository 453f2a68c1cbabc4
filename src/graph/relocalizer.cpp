// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/relocalizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"
#include "wall_comparison.h"

namespace kestrel {
namespace {

/// Number of points of the final matches, and of beams that are compared with the map.
constexpr std::size_t kMatchPoints = 720, kComparedBeams = 720, kScanPoints = 360;
/// Fewer hits fit in too many places.
constexpr std::size_t kLeastHits = 30;
/// Poses that differ by less than this are one place.
constexpr double kSameM = 0.6, kSameRad = 0.35;
/// A single scan agrees if it fits at the same place up to this.
constexpr double kAgreeM = 0.2, kAgreeRad = 0.05, kSingleFit = 0.6;
/// The errors of the walls of a map, which all beams have in common, see LoopMatcher.
constexpr double kPlaceM = 0.015, kPlaceRad = 0.004, kMatchFactor = 4.0;
/// Hypotheses with a lower score than the best by this are not refined.
constexpr double kSearchMargin = 0.12;
/// The likelihood of a good scan whose known part is as small as allowed.
constexpr double kSearchScore = 0.55;

Points pointsOf(const RelocalizationQuery& query) {
  Points result;
  for (const RelocalizationQuery::Part& part : query.parts) {
    for (const PlanarRay& ray : part.scan.rays) {
      if (ray.hit) result.push_back((part.base_T_scan * ray.end.cast<double>()).cast<float>());
    }
  }
  return result;
}

}  // namespace

const char* toString(RelocalizationState state) {
  switch (state) {
    case RelocalizationState::kSearching:
      return "searching";
    case RelocalizationState::kFound:
      return "found";
    case RelocalizationState::kAmbiguous:
      return "ambiguous";
    case RelocalizationState::kUnknown:
      return "unknown";
  }
  return "unknown";
}

GaussianPose2 RelocalizationAnswer::pose() const {
  GaussianPose2 result;
  if (hypotheses.empty()) return result;
  const MatchResult& match = hypotheses.front().match;
  result.mean = match.pose;
  result.covariance = kMatchFactor * match.covariance;
  result.covariance.diagonal() += Eigen::Vector3d(kPlaceM, kPlaceM, kPlaceRad).cwiseAbs2();
  return result;
}

Relocalizer::Relocalizer(const GlobalMap& map, const MatcherConfig& matcher,
                         const RelocalizationConfig& config)
    : map_(map), matcher_(matcher), config_(config) {}

void Relocalizer::begin(RelocalizationQuery query) {
  query_ = std::move(query);
  answer_ = {};
  points_ = pointsOf(query_);
  search_.reset();
  if (points_.size() < kLeastHits) {
    answer_.state = RelocalizationState::kUnknown;
    answer_.reason = "too few hits";
    return;
  }
  GlobalSearchConfig config;
  config.min_score = kSearchScore;
  config.margin = kSearchMargin;
  config.region = query_.region;
  search_.emplace(map_, points_, config);
}

const RelocalizationAnswer& Relocalizer::advance(std::int64_t work) {
  if (!search_) return answer_;
  WorkBudget budget(std::min(work, config_.most_work - answer_.work));
  const bool done = search_->run(budget);
  answer_.work += budget.used();
  if (done || answer_.work + work > config_.most_work) conclude(done && search_->isComplete());
  return answer_;
}

const RelocalizationAnswer& Relocalizer::locate(RelocalizationQuery query) {
  begin(std::move(query));
  return advance(config_.most_work);
}

WallAgreement Relocalizer::wallsAt(const Pose2& map_T_base) const {
  std::vector<ScanInMap> scans;
  for (const RelocalizationQuery::Part& part : query_.parts)
    scans.push_back({map_T_base * part.base_T_scan, &part.scan});
  return compareWalls(map_.map(), scans, kComparedBeams, CrossedWalls::kBetweenEnds);
}

PlaceHypothesis Relocalizer::hypothesisAt(const Pose2& guess) const {
  PlaceHypothesis result;
  result.match = matchNear(map_.map(), sampled(points_, kMatchPoints), guess, matcher_);
  result.walls = wallsAt(result.match.pose);
  return result;
}

const char* Relocalizer::problemOf(const PlaceHypothesis& best) const {
  if (best.match.score < config_.min_fit) return "the scan does not fit";
  if (best.match.known < config_.min_known) return "too little of the scan is in the map";
  // In a whole map, many places fit a scan that shows little wall.
  const bool contradicts = query_.region
                               ? best.walls.possibleContradiction() > kMostContradiction
                               : best.walls.contradictionBound() > config_.max_contradiction;
  if (contradicts) return "the scan contradicts the map";
  if (best.match.constraint < config_.min_constraint) return "a direction is unobservable";
  return "";
}

void Relocalizer::conclude(bool complete) {
  for (const GlobalHypothesis& found : search_->hypotheses())
    answer_.hypotheses.push_back(hypothesisAt(found.pose));
  search_.reset();
  rank();
  judge(complete);
}

/// Best first. Some hypotheses may have met at one place.
void Relocalizer::rank() {
  std::vector<PlaceHypothesis> places, all = std::move(answer_.hypotheses);
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.score() > b.score(); });
  for (const PlaceHypothesis& hypothesis : all) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const auto& other) {
      return isNear({other.match.pose, kSameM, kSameRad}, hypothesis.match.pose);
    });
    if (!known) places.push_back(hypothesis);
  }
  answer_.hypotheses = std::move(places);
}

void Relocalizer::judge(bool complete) {
  const std::vector<PlaceHypothesis>& all = answer_.hypotheses;
  answer_.state = RelocalizationState::kUnknown;
  answer_.reason = complete ? "the scan does not fit" : "it fits in too many places to try all";
  if (all.empty()) return;
  answer_.margin = all.size() > 1 ? all[0].score() - all[1].score() : all[0].score();
  const char* problem = problemOf(all.front());
  if (*problem != '\0') {
    answer_.reason = problem;
  } else if (!complete || answer_.margin < neededMargin()) {
    answer_.state = RelocalizationState::kAmbiguous;
    if (complete) answer_.reason = "the scan fits in several places";
  } else if ((answer_.agreement = agreementAt(all.front().match)) < config_.min_agreement) {
    answer_.reason = "the scans do not agree";
  } else {
    answer_.state = RelocalizationState::kFound;
    answer_.reason = "";
  }
}

/// A scan that shows little wall fits elsewhere by chance. The difference must be larger than its
/// standard deviation.
double Relocalizer::neededMargin() const {
  double variance = answer_.hypotheses[0].walls.variance();
  if (answer_.hypotheses.size() > 1) variance += answer_.hypotheses[1].walls.variance();
  return std::max(config_.min_margin, std::sqrt(variance));
}

/// The share of the single scans that fit where all together fit.
double Relocalizer::agreementAt(const MatchResult& found) const {
  if (query_.parts.size() < 2) return 1.0;
  int agreeing = 0, all = 0;
  for (const RelocalizationQuery::Part& part : query_.parts) {
    const Points points = sampled(hitsOf(part.scan), kScanPoints);
    if (points.size() < kLeastHits) continue;
    const Pose2 expected = found.pose * part.base_T_scan;
    const MatchResult single = matchNear(map_.map(), points, expected, matcher_);
    Eigen::Vector2d away = single.pose.translation() - expected.translation();
    if (single.degenerate)
      away -= single.degenerate_direction * single.degenerate_direction.dot(away);
    ++all;
    if (single.score >= kSingleFit && away.norm() < kAgreeM &&
        std::abs(normalizeAngle(single.pose.yaw - expected.yaw)) < kAgreeRad)
      ++agreeing;
  }
  return all == 0 ? 1.0 : static_cast<double>(agreeing) / all;
}

std::size_t Relocalizer::memoryBytes() const {
  return map_.memoryBytes() + points_.capacity() * sizeof(Eigen::Vector2f) +
         (search_ ? search_->memoryBytes() : 0);
}

}  // namespace kestrel
