// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/relocalizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/matching/place_match.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/matching/unknown_score.h"

namespace kestrel {
namespace {

/// Number of points of the final matches, and of beams that are followed through the map.
constexpr std::size_t kMatchPoints = 720, kFollowedBeams = 240, kScanPoints = 360;
/// Fewer hits fit in too many places.
constexpr std::size_t kLeastHits = 30;
/// A beam passes through a wall if it goes on for so long behind it, m.
constexpr double kBehindM = 0.5;
/// A wall has so many hits in a cell. A beam passes through it if the square of the sine of the
/// angle between them is larger than this.
constexpr float kWallHits = 3.0F, kAcross = 0.15F;
/// Poses that differ by less than this are one place.
constexpr double kSameM = 0.6, kSameRad = 0.35;
/// A single scan agrees if it fits at the same place up to this.
constexpr double kAgreeM = 0.2, kAgreeRad = 0.05, kSingleFit = 0.6;
/// The errors of the walls of a map, which all beams have in common, see LoopMatcher.
constexpr double kPlaceM = 0.015, kPlaceRad = 0.004, kMatchFactor = 4.0;
/// Hypotheses with a lower score than the best by this are not refined.
constexpr double kSearchMargin = 0.12;
/// The likelihood of a good scan whose known part is as small as allowed.
constexpr double kSearchScore = 0.45;

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

/// Whether a beam passes through a wall. Beams along a wall and through single objects do not
/// count: a small error of the pose or a moved chair explains them.
bool Relocalizer::crosses(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const SurfelField& surface = map_.map().surface();
  const auto step = static_cast<double>(surface.resolution());
  const double length = (to - from).norm();
  const Eigen::Vector2f along = ((to - from) / std::max(length, step)).cast<float>();
  const float near2 = surface.resolution() * surface.resolution();
  for (double at = 0.0; at < length - kBehindM; at += step) {
    const Eigen::Vector2f point = from.cast<float>() + along * static_cast<float>(at);
    const Surfel* wall = surface.nearest(point);
    if (wall == nullptr || isPoint(*wall) || wall->count < kWallHits) continue;
    if ((point - wall->mean).squaredNorm() > near2) continue;
    const float across = along.x() * (wall->a11 * along.x() + 2.0F * wall->a12 * along.y()) +
                         along.y() * wall->a22 * along.y();
    if (across > kAcross) return true;
  }
  return false;
}

/// The share of the beams that would pass through walls.
double Relocalizer::crossingAt(const Pose2& pose) const {
  std::size_t beams = 0, crossing = 0, number = 0;
  const std::size_t each = std::max<std::size_t>(1, points_.size() / kFollowedBeams);
  for (const RelocalizationQuery::Part& part : query_.parts) {
    const Pose2 map_T_scan = pose * part.base_T_scan;
    for (const PlanarRay& ray : part.scan.rays) {
      if (!ray.hit || number++ % each != 0) continue;
      ++beams;
      if (crosses(map_T_scan * ray.origin.cast<double>(), map_T_scan * ray.end.cast<double>()))
        ++crossing;
    }
  }
  return beams == 0 ? 0.0 : static_cast<double>(crossing) / static_cast<double>(beams);
}

PlaceHypothesis Relocalizer::hypothesisAt(const Pose2& guess) const {
  PlaceHypothesis result;
  result.match = matchNear(map_.map(), sampled(points_, kMatchPoints), guess, matcher_);
  result.crossing = crossingAt(result.match.pose);
  const double known = result.match.known;
  result.score = result.match.score * known + kUnknownScore * (1.0 - known) - result.crossing;
  return result;
}

const char* Relocalizer::problemOf(const PlaceHypothesis& best) const {
  if (best.match.score < config_.min_fit) return "the scan does not fit";
  if (best.match.known < config_.min_known) return "too little of the scan is in the map";
  if (best.contradiction() > config_.max_contradiction) return "the scan contradicts the map";
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
                   [](const auto& a, const auto& b) { return a.score > b.score; });
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
  answer_.margin = all.size() > 1 ? all[0].score - all[1].score : all[0].score;
  const char* problem = problemOf(all.front());
  if (*problem != '\0') {
    answer_.reason = problem;
  } else if (!complete || answer_.margin < config_.min_margin) {
    answer_.state = RelocalizationState::kAmbiguous;
    if (complete) answer_.reason = "the scan fits in several places";
  } else if ((answer_.agreement = agreementAt(all.front().match)) < config_.min_agreement) {
    answer_.reason = "the scans do not agree";
  } else {
    answer_.state = RelocalizationState::kFound;
    answer_.reason = "";
  }
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
