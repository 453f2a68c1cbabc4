// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/ambiguity.h"

#include <Eigen/Geometry>

#include "hybrid_matcher.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Poses that differ by less than this are one explanation.
constexpr double kSameM = 0.5, kSameRad = 0.35;
/// The second explanation is nearly as good if its score is lower by less than this.
constexpr double kClearlyBetter = 0.1;
/// The score of the pose itself is the best one within this distance, because the grid of the
/// search has steps.
constexpr SearchWindow kAtPose{0.1, 0.02};

/// The score without the penalty of the motion: the question is only how well the scan fits.
CorrelativeConfig withoutPreference(CorrelativeConfig config) {
  config.linear_preference = config.angular_preference = 0.0;
  return config;
}

}  // namespace

std::optional<Pose2> secondExplanation(const Submap& map, const MatchRequest& request,
                                       const MatchResult& found, const MatcherConfig& config) {
  const Points points = thinned(request.points, kLostPoints);
  const CorrelativeConfig search = withoutPreference(config.correlative);
  const double first = searchWindow(map.surface(), points, found.pose, kAtPose, search).score;
  const Pose2& predicted = request.initial_guesses.front();
  const Pose2 center(request.last.x, request.last.y,
                     request.yaw_known ? predicted.yaw : request.last.yaw);
  const ExcludedPoses near{found.pose, kSameM, kSameRad,
                           found.degenerate ? found.degenerate_direction : Eigen::Vector2d(0, 0)};
  const SearchResult second = searchWindow(map.surface(), points, center,
                                           searchWindows(config, request).back(), search, near);
  return second.score > first - kClearlyBetter ? std::optional(second.pose) : std::nullopt;
}

}  // namespace kestrel
