// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/place_match.h"

#include <algorithm>
#include <vector>

#include "hybrid_matcher.h"
#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/matching/work_budget.h"
#include "rough_search.h"
#include "sketch.h"

namespace kestrel {
namespace {

/// Number of points for the search, and for the comparison of its hypotheses.
constexpr std::size_t kSearchPoints = 360, kComparedPoints = 240;
/// Poses that differ by less than this are one explanation.
constexpr double kSamePlaceM = 0.6, kSamePlaceRad = 0.35;
constexpr std::size_t kRefinedPlaces = 2;

struct Explanation {
  Pose2 pose;
  double score = 0.0;
};

double scoreOf(const Fit& fit) { return fit.score * fit.known; }

}  // namespace

MatchResult matchNear(const Submap& place, const Points& points, const Pose2& guess,
                      const MatcherConfig& config) {
  const HybridMatcher matcher(config);
  return matcher.refined(place, points, guess);
}

bool isSamePlace(const MatchResult& match, const Pose2& other) {
  const Eigen::Vector2d ignored =
      match.degenerate ? match.degenerate_direction : Eigen::Vector2d(Eigen::Vector2d::Zero());
  return isNear({match.pose, kSamePlaceM, kSamePlaceRad, ignored}, other);
}

PlaceMatch matchPlace(const Submap& place, const Points& points, const Pose2& center,
                      const SearchWindow& window, const MatcherConfig& config, std::int64_t work) {
  PlaceMatch result;
  result.match.pose = center;
  RoughWindow rough{center, window, config.correlative, {}, 0};
  rough.preferences.linear_preference = rough.preferences.angular_preference = 0.0;
  WorkBudget budget(work);
  const Hypotheses hypotheses =
      searchRoughly(place.surface(), sampled(points, kSearchPoints), rough, budget);
  result.complete = hypotheses.complete;
  const Points few = sampled(points, kComparedPoints);
  std::vector<Explanation> found;
  for (const Pose2& hypothesis : hypotheses.poses) {
    const Pose2 pose = sketch(place.surface(), few, hypothesis);
    found.push_back({pose, scoreOf(fitOf(place, few, pose, config.score_scale_m))});
  }
  if (found.empty()) return result;
  std::stable_sort(found.begin(), found.end(),
                   [](const Explanation& a, const Explanation& b) { return a.score > b.score; });
  for (std::size_t i = 0; i < std::min(kRefinedPlaces, found.size()); ++i) {
    const MatchResult match = matchNear(place, points, found[i].pose, config);
    const double score = match.score * match.known;
    if (score <= result.score) continue;
    result.match = match;
    result.score = score;
  }
  for (const Explanation& other : found) {
    if (isSamePlace(result.match, other.pose)) continue;
    result.second_score = other.score;
    break;
  }
  return result;
}

}  // namespace kestrel
