// SPDX-License-Identifier: BSD-3-Clause
#include "progressive_matcher.h"

#include <algorithm>
#include <array>

#include "hybrid_matcher.h"

namespace kestrel {
namespace {

/// A search window of the other matchers corresponds to this many sigmas of the candidates.
constexpr double kWindowSigmas = 2.0;

}  // namespace

MatchResult ProgressiveMatcher::match(const Submap& map, const MatchRequest& request) const {
  MatchResult result;
  Candidate best = refine(map, request, request.initial_guesses.front());
  result.iterations = best.refinement.levels;
  for (std::size_t i = 1;
       i < request.initial_guesses.size() && best.fit.score < config_.search_score; ++i) {
    const Candidate other = refine(map, request, request.initial_guesses[i]);
    result.iterations += other.refinement.levels;
    if (other.fit.score > best.fit.score) best = other;
  }
  if (best.fit.score < config_.search_score) search(map, request, result, best);
  result.pose = best.pose;
  result.converged = !best.refinement.stopped && best.refinement.finest.vote > 0.0;
  // The covariance has two independent parts: the error of the maximum over the candidates, and the
  // error of the scan, including unobservable directions. The spread of the candidates alone is
  // limited by the candidate space.
  const auto scale = static_cast<float>(config_.score_scale_m);
  const NormalEquations distances =
      linearizeDistance(map.surface(), request.points, result.pose, scale);
  fillUncertainty(map, request.points, {scale, distances, best.fit}, config_, result);
  result.covariance += best.refinement.finest.covariance;
  fillStages(map, request.points, best.refinement.poses, config_.score_scale_m, result);
  return result;
}

ProgressiveMatcher::Candidate ProgressiveMatcher::refine(const Submap& map,
                                                         const MatchRequest& request,
                                                         const Pose2& initial_guess) const {
  Candidate result;
  result.refinement =
      refiner_.refine(map.grid(), request.points, initial_guess,
                      motionSpread(request.last, initial_guess, config_.progressive));
  result.pose = result.refinement.poses.back();
  result.fit = fitOf(map, request.points, result.pose, config_.score_scale_m);
  return result;
}

void ProgressiveMatcher::search(const Submap& map, const MatchRequest& request, MatchResult& result,
                                Candidate& best) const {
  result.searched = true;
  for (const SearchWindow& window : searchWindows(config_, request)) {
    if (best.fit.score >= config_.search_score) break;
    const CandidateSpread spread{window.linear_m / kWindowSigmas,
                                 window.angular_rad / kWindowSigmas};
    const Candidate other = refine(
        map, request,
        refiner_.findCoarsely(map.grid(), request.points, request.initial_guesses.front(), spread));
    result.iterations += other.refinement.levels;
    if (other.fit.score > best.fit.score + jumpMargin(config_, request, other.pose)) best = other;
  }
}

}  // namespace kestrel
