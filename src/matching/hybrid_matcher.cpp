// SPDX-License-Identifier: BSD-3-Clause
#include "hybrid_matcher.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "kestrel_slam/matching/covariance.h"
#include "kestrel_slam/matching/thinned.h"
#include "kestrel_slam/matching/weak_motion.h"
#include "known_walls.h"
#include "rough_search.h"
#include "sketch.h"
#include "surfel_lanes.h"

namespace kestrel {
namespace {

constexpr std::size_t kLastStage = kMatchStages - 1;
/// Lower limit for the residuals, because map and sensor have noise.
constexpr double kMinResidualM = 0.01;
/// The errors of neighboring beams are correlated: n beams count as n / kBeamCorrelation.
constexpr double kBeamCorrelation = 4.0;
/// Points that do not fit (a person, the edge of a table) pull in one direction, so their effect
/// does not average out over the beams. The bias is this length (m) times their share; the Cauchy
/// weight of scale s bounds it by s / 2. Calibrated on simulated flights (measure_flights).
constexpr double kMisfitBiasM = 0.011;
/// Standard deviation along an unobservable direction, m.
constexpr double kUnconstrainedM = 0.5;
/// At least this many points show the weakest motion, where a scan has more.
constexpr std::size_t kWeakPoints = 120;
/// The Hessian of an empty scan is zero.
constexpr double kLeastTrace = 1e-9;
/// Distance of the samples, in standard deviations of the Hessian covariance. Closer samples would
/// measure the discretization error of the map.
constexpr double kSampleSpread = 3.0;

/// A pose is well constrained if this share of the points is on walls with this standard deviation,
/// and if these points constrain both directions (see leastConstraint). This does not happen by
/// chance, even if the other points do not fit: people, moved objects, or an object that covers
/// part of the view.
constexpr double kConstrainedShare = 0.4, kConstrainedSigmaM = 0.03, kConstrainedLeast = 0.1;

/// This many of the hypotheses of a search are refined with all points.
constexpr std::size_t kRefined = 4;
/// Work to refine a hypothesis.
std::int64_t refineWork(const Points& points) {
  constexpr std::int64_t kPerPoint = 400, kCoarseStages = 150'000;
  return kCoarseStages + kPerPoint * static_cast<std::int64_t>(points.size());
}

bool isWellConstrained(const Fit& fit) {
  return fit.on_wall >= kConstrainedShare &&
         fit.residual_variance <= kConstrainedSigmaM * kConstrainedSigmaM &&
         leastConstraint(fit) >= kConstrainedLeast;
}

/// What the score loses if points in unknown space count as misses. Hypotheses are compared so: of
/// many poses, one where most points are in unknown space and the others fit by chance would have
/// the highest score.
double unknownPart(const Fit& fit) { return fit.score * (1.0 - fit.known); }

/// Whether the points moved farther from `guess` to `found` than the coarsest stage reaches. Then
/// the descent began outside of the basin of convergence, for example in a fast turn, and it may
/// have found another optimum than the right one, even if the scan fits well there.
bool leftBasin(const Points& points, const Pose2& guess, const Pose2& found) {
  const Pose2 motion = guess.between(found);
  double moved = 0.0;
  for (const Eigen::Vector2f& point : points) {
    const Eigen::Vector2d at = point.cast<double>();
    moved += (motion * at - at).norm();
  }
  return moved > static_cast<double>(kStageScales.front()) * static_cast<double>(points.size());
}

bool isInside(const SearchWindow& window, const Pose2& motion) {
  return motion.translation().lpNorm<Eigen::Infinity>() <= window.linear_m &&
         std::abs(motion.yaw) <= window.angular_rad;
}

/// Covariance of the match from the Hessian and the variance of the residuals, or from samples
/// around the pose.
Eigen::Matrix3d covarianceOf(const Submap& map, const Points& points, const Optimum& optimum,
                             const MatcherConfig& config, const Pose2& pose) {
  const Fit& fit = optimum.fit;
  const double misfit = kMisfitBiasM * (1.0 - fit.score);
  const double variance =
      kBeamCorrelation * std::max(fit.residual_variance, kMinResidualM * kMinResidualM) +
      fit.known * static_cast<double>(points.size()) * misfit * misfit;
  const Eigen::Matrix3d hessian = optimum.at_pose.hessian.cast<double>();
  const Eigen::Matrix3d covariance = hessianCovariance(hessian, variance);
  if (config.covariance != "sampled") return covariance;
  const auto cost = [&](const Pose2& at) {
    return static_cast<double>(linearizeDistance(map.surface(), points, at, optimum.scale_m).cost);
  };
  return sampledCovariance(cost, pose, kSampleSpread * kSampleSpread * covariance, variance);
}

}  // namespace

/// The local optima for a request. Guesses are often the same pose: those of a vehicle that does
/// not move, and the hypotheses of two windows.
class HybridMatcher::Optima {
 public:
  Optima(const HybridMatcher& matcher, const Submap& map, const MatchRequest& request)
      : matcher_(matcher), map_(map), request_(request) {}

  /// See refine.
  Candidate from(const Pose2& guess, std::size_t first_stage = 0) {
    return from(guess, request_.near ? Hits::kOfKnownWalls : Hits::kAll, first_stage);
  }

  /// The same for a hypothesis of a search, which may be anywhere.
  Candidate fromHypothesis(const Pose2& pose) { return from(pose, Hits::kAll, 0); }

 private:
  struct Entry {
    Pose2 guess;
    Hits hits;
    std::size_t first_stage;
    Candidate optimum;
  };

  Candidate from(const Pose2& guess, Hits hits, std::size_t first_stage) {
    for (const Entry& entry : known_) {
      if (entry.first_stage == first_stage && entry.hits == hits && isSamePose(entry.guess, guess))
        return entry.optimum;
    }
    known_.push_back(
        {guess, hits, first_stage, matcher_.refine(map_, request_, guess, hits, first_stage)});
    return known_.back().optimum;
  }

  const HybridMatcher& matcher_;
  const Submap& map_;
  const MatchRequest& request_;
  std::vector<Entry> known_;
};

MatchResult HybridMatcher::match(const Submap& map, const MatchRequest& request) const {
  MatchResult result;
  Optima optima(*this, map, request);
  // If the initial guess is accurate, the coarse stages are skipped. They could only move the pose
  // to a place where objects that are not in the map seem to fit.
  Candidate best = optima.from(request.initial_guesses.front(), request.trusted ? kLastStage : 0);
  result.iterations = best.descent.iterations;
  const std::size_t first = request.trusted ? 0 : 1;
  const auto is_doubtful = [&] { return best.jumped && !request.trusted; };
  for (std::size_t i = first;
       i < request.initial_guesses.size() && (is_doubtful() || best.fit.score < config_.good_score);
       ++i) {
    Candidate other = optima.from(request.initial_guesses[i]);
    ++result.fallbacks;
    result.iterations += other.descent.iterations;
    const double margin = request.trusted ? jumpMargin(config_, request, other.descent.pose) : 0.0;
    if (other.worth > best.worth + margin) best = other;
  }
  const Pose2& first_guess = request.initial_guesses.front();
  if (is_doubtful()) {
    // The yaw is found more reliably than the position, and the position changes less in a turn.
    const Candidate other = optima.from(Pose2(first_guess.x, first_guess.y, best.descent.pose.yaw));
    result.iterations += other.descent.iterations;
    if (other.worth > best.worth) best = other;
  }
  const bool jumps = isJump(request, best.descent.pose);
  if ((best.fit.score < config_.search_score || jumps) && !request.trusted) {
    // An object that covers part of the view may mislead the coarse stages.
    const Candidate near = optima.from(first_guess, kLastStage);
    result.iterations += near.descent.iterations;
    const double margin = jumps ? jumpMargin(config_, request, best.descent.pose) : 0.0;
    if (near.worth + margin > best.worth) best = near;
  }
  const bool fits =
      best.fit.score >= config_.search_score || (!request.lost && isWellConstrained(best.fit));
  if (!fits || is_doubtful() || request.prior || request.wide)
    search(map, request, optima, result, best);
  if (request.lost) {
    // The last descent began far away and may have ended before it converged.
    const Candidate closer = optima.from(best.descent.pose, kLastStage);
    result.iterations += closer.descent.iterations;
    if (closer.worth > best.worth) best = closer;
  }
  fill(map, request, best, result);
  return result;
}

void HybridMatcher::fill(const Submap& map, const MatchRequest& request, const Candidate& best,
                         MatchResult& result) const {
  const Points& points = request.points;
  const Beams shown_by = request.prior ? Beams::kAll : Beams::kCertain;
  result.pose = best.descent.pose;
  result.converged = best.descent.converged;
  fillUncertainty(map, points, {kStageScales.back(), best.descent.at_pose, best.fit, shown_by},
                  config_, result);
  fillStages(map, points, best.stages, config_.score_scale_m, result);
}

MatchResult HybridMatcher::refined(const Submap& map, const Points& points,
                                   const Pose2& guess) const {
  const MatchRequest request{points, guess, {guess}};
  const Candidate best = refine(map, request, guess, Hits::kAll);
  MatchResult result;
  result.iterations = best.descent.iterations;
  fill(map, request, best, result);
  return result;
}

void HybridMatcher::search(const Submap& map, const MatchRequest& request, Optima& optima,
                           MatchResult& result, Candidate& best) const {
  result.searched = true;
  WorkBudget budget(kSearchWork);
  std::vector<SearchWindow> windows = searchWindows(config_, request);
  if (request.lost) windows.erase(windows.begin(), windows.end() - 1);
  const std::size_t expected = windows.size();
  const double back_m = request.turned_back_m + config_.near_window.linear_m;
  if (request.turned_back_m > 0.0 && back_m > windows.back().linear_m)
    windows.push_back({back_m, windows.back().angular_rad});
  const Pose2 center = searchCenter(request);
  SearchWindow searched{0.0, 0.0};
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const SearchWindow& window = windows[i];
    const bool required = (request.prior || request.wide) && i == 0;
    // The surroundings of a pose outside of the window were not searched.
    if (best.fit.score >= config_.search_score && !required &&
        isInside(searched, center.between(best.descent.pose)))
      break;
    searched = window;
    const RoughWindow rough{
        center,        window, preferencesFor(request, config_.correlative), {}, request.lost_scans,
        request.memory};
    const Hypotheses hypotheses = searchRoughly(map.surface(), request.points, rough, budget);
    result.incomplete = !hypotheses.complete;
    std::optional<Candidate> found;
    for (const Pose2& pose : mostLikely(map, request, hypotheses.poses, budget)) {
      const Candidate other = optima.fromHypothesis(pose);
      result.iterations += other.descent.iterations;
      if (!found || other.all_points_score > found->all_points_score) found = other;
    }
    if (!found) continue;
    // A poor fit so far away is found by chance.
    if (i >= expected && found->fit.score < config_.search_score) continue;
    // Of two jumps the better one is taken.
    const double margin = best.jumped ? 0.0 : jumpMargin(config_, request, found->descent.pose);
    if (found->worth > best.worth + margin) best = *found;
  }
}

/// The hypotheses that fit best after a descent with a part of the points, best first.
std::vector<Pose2> HybridMatcher::mostLikely(const Submap& map, const MatchRequest& request,
                                             const std::vector<Pose2>& hypotheses,
                                             WorkBudget& budget) const {
  const Points sample = sampled(request.points, kSketchPoints);
  std::vector<std::pair<double, Pose2>> ranking;  // negative score, pose
  for (const Pose2& pose :
       sketches(map.surface(), sample, hypotheses, kRefined, budget, request.memory)) {
    const Fit fit = fitOf(map, sample, pose, config_.score_scale_m);
    const double penalized = penalizedScore(request, fit, pose, config_.correlative);
    ranking.emplace_back(unknownPart(fit) - penalized, pose);
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Pose2> result;
  for (const auto& [score, pose] : ranking) {
    const bool affordable = budget.take(refineWork(request.points));
    if (result.size() == kRefined || (!affordable && !result.empty())) break;
    result.push_back(pose);
  }
  return result;
}

HybridMatcher::Candidate HybridMatcher::refine(const Submap& map, const MatchRequest& request,
                                               const Pose2& initial_guess, Hits hits,
                                               std::size_t first_stage) const {
  Candidate result;
  const Points few = thinned(request.points, kCoarsePoints);
  GaussNewtonConfig coarse = config_.gauss_newton;
  coarse.min_step_m = std::max(coarse.min_step_m, kCoarseStepM);
  coarse.min_step_rad = std::max(coarse.min_step_rad, kCoarseStepRad);
  int iterations = 0;
  Pose2 pose = initial_guess;
  for (std::size_t stage = first_stage; stage < kMatchStages; ++stage) {
    const bool last = stage == kLastStage;
    const float scale = kStageScales[stage];
    const Points& all = last ? request.points : few;
    Points known;
    if (hits == Hits::kOfKnownWalls)
      known = hitsOfKnownWalls(map, all, pose, request.points.size());
    const Points& points = hits == Hits::kOfKnownWalls ? known : all;
    const Eigen::Vector3f pull =
        Eigen::Vector3f::Constant(kPriorWeight * static_cast<float>(points.size()));
    LastSurfels surfels(points.size());
    result.descent =
        descend(pose, last ? config_.gauss_newton : coarse, pull, [&](const Pose2& at) {
          return linearizeDistance(map.surface(), points, at, scale, surfels);
        });
    pose = result.descent.pose;
    iterations += result.descent.iterations;
    result.stages[stage] = pose;
  }
  for (std::size_t stage = 0; stage < first_stage; ++stage) result.stages[stage] = pose;
  result.descent.iterations = iterations;
  result.fit = fitOf(map, request.points, pose, config_.score_scale_m);
  const double penalized = penalizedScore(request, result.fit, pose, config_.correlative);
  result.all_points_score = penalized - unknownPart(result.fit);
  result.worth = request.near ? result.all_points_score : penalized;
  result.jumped = leftBasin(few, initial_guess, pose);
  return result;
}

void fillStages(const Submap& map, const Points& points,
                const std::array<Pose2, kMatchStages>& poses, double scale_m, MatchResult& result) {
  const Points few = thinned(points, kCoarsePoints);
  result.stages.back() = {poses.back(), result.score};
  for (std::size_t i = 0; i + 1 < kMatchStages; ++i) {
    const double scale = scale_m * static_cast<double>(1U << (kMatchStages - 1 - i));
    result.stages[i] = {poses[i], fitOf(map, few, poses[i], scale).score};
  }
}

void fillUncertainty(const Submap& map, const Points& points, const Optimum& optimum,
                     const MatcherConfig& config, MatchResult& result) {
  const Fit& fit = optimum.fit;
  result.score = fit.score;
  result.known = fit.known;
  const WeakMotion weak =
      weakMotion(map, thinned(points, kWeakPoints), result.pose, optimum.shown_by);
  const Eigen::Vector2d& weakest = weak.direction;
  const double share = weak.constraint;
  result.constraint = share;
  result.degenerate = share < config.degenerate_share;
  result.covariance = covarianceOf(map, points, optimum, config, result.pose);
  const Eigen::Matrix2d across = optimum.at_pose.hessian.cast<double>().topLeftCorner<2, 2>();
  const double hessian_share =
      weakest.dot(across * weakest) / std::max(across.trace(), kLeastTrace);
  const double constrained = std::max(share, config.degenerate_share);
  result.covariance =
      stretched(result.covariance, weakest, std::sqrt(std::max(hessian_share / constrained, 1.0)));
  result.degenerate_direction = weakest;
  result.along_variance = weakest.dot(result.covariance.topLeftCorner<2, 2>() * weakest);
  result.degenerate_turn = weak.turn_rad_m;
  if (!result.degenerate) return;
  result.covariance.topLeftCorner<2, 2>() +=
      kUnconstrainedM * kUnconstrainedM * (weakest * weakest.transpose());
}

}  // namespace kestrel
