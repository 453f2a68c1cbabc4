// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/ambiguity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hybrid_matcher.h"
#include "kestrel_slam/matching/thinned.h"
#include "rough_search.h"
#include "sketch.h"

namespace kestrel {
namespace {

/// Poses that differ by less than this are one explanation.
constexpr double kSameM = 0.5, kSameRad = 0.35;

/// How well the points fit at poses: without the penalty of the motion, because the question is
/// only how well the scan fits.
class Comparison {
 public:
  Comparison(const SurfelField& surface, const MatchRequest& request, const MatcherConfig& config)
      : surface_(surface), points_(sampled(request.points, kSketchPoints)), config_(config) {}

  const Points& points() const { return points_; }

  /// Mean likelihood of the points, as in the exhaustive search.
  double scoreAt(const Pose2& pose) const {
    const double inverse = -0.5 / (config_.correlative.sigma_m * config_.correlative.sigma_m);
    double sum = 0.0;
    for (const Eigen::Vector2f& p : points_) {
      const Eigen::Vector2f point = (pose * p.cast<double>()).cast<float>();
      const Surfel* surfel = surface_.nearest(point);
      if (surfel == nullptr) continue;
      sum += std::exp(inverse * static_cast<double>((point - surfel->mean).squaredNorm()));
    }
    return sum / static_cast<double>(std::max<std::size_t>(1, points_.size()));
  }

 private:
  const SurfelField& surface_;
  Points points_;
  const MatcherConfig& config_;
};

RoughWindow windowOf(const MatchRequest& request, const MatchResult& found,
                     const MatcherConfig& config) {
  RoughWindow window{searchCenter(request), searchWindows(config, request).back(),
                     config.correlative,    {},
                     request.lost_scans,    request.memory};
  window.preferences.linear_preference = window.preferences.angular_preference = 0.0;
  window.excluded = {found.pose, kSameM, kSameRad,
                     found.degenerate ? found.degenerate_direction : Eigen::Vector2d(0, 0)};
  return window;
}

}  // namespace

std::optional<Pose2> secondExplanation(const Submap& map, const MatchRequest& request,
                                       const MatchResult& found, const MatcherConfig& config,
                                       double margin) {
  const RoughWindow window = windowOf(request, found, config);
  const Comparison comparison(map.surface(), request, config);
  WorkBudget budget(kSearchWork);
  const Hypotheses hypotheses = searchRoughly(map.surface(), request.points, window, budget);
  const double first = comparison.scoreAt(found.pose);
  // What was not searched may hold a pose that fits as well.
  double least = hypotheses.complete ? first - margin : -1.0;
  std::optional<Pose2> second;
  for (const Pose2& pose :
       sketches(map.surface(), comparison.points(), hypotheses.poses, 1, budget, request.memory)) {
    const double score = comparison.scoreAt(pose);
    if (score <= least || isNear(window.excluded, pose)) continue;
    least = score;
    second = pose;
  }
  return second;
}

}  // namespace kestrel
