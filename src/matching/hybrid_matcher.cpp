// SPDX-License-Identifier: BSD-3-Clause
#include "hybrid_matcher.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/matching/covariance.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Cauchy scales of the stages, m. A wide scale has a large basin of convergence; the last one only
/// uses points close to a wall. With 0.1 m as the last scale the error of the recordings is 10 %
/// larger, with 0.2 m 30 %.
constexpr std::array<float, kMatchStages> kStageScales = {0.3F, 0.12F, 0.05F};
/// The early stages only have to reach the basin of convergence of the next stage.
constexpr double kCoarseStepM = 0.01, kCoarseStepRad = 0.005;
/// Angular size of the search window if the gyro gives the yaw, rad.
constexpr double kKnownYawWindow = 0.1;
constexpr std::size_t kLastStage = kMatchStages - 1;
/// Information of the prior at the initial guess, relative to that of the points across a wall. It
/// only has an effect in unobservable directions.
constexpr float kPriorWeight = 1e-3F;
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

bool isWellConstrained(const Fit& fit) {
  return fit.on_wall >= kConstrainedShare &&
         fit.residual_variance <= kConstrainedSigmaM * kConstrainedSigmaM &&
         leastConstraint(fit) >= kConstrainedLeast;
}

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

MatchResult HybridMatcher::match(const Submap& map, const MatchRequest& request) const {
  MatchResult result;
  // If the initial guess is accurate, the coarse stages are skipped. They could only move the pose
  // to a place where objects that are not in the map seem to fit.
  Candidate best =
      refine(map, request, request.initial_guesses.front(), request.trusted ? kLastStage : 0);
  result.iterations = best.descent.iterations;
  const std::size_t first = request.trusted ? 0 : 1;
  const auto is_doubtful = [&] { return best.jumped && !request.trusted; };
  for (std::size_t i = first;
       i < request.initial_guesses.size() && (is_doubtful() || best.fit.score < config_.good_score);
       ++i) {
    Candidate other = refine(map, request, request.initial_guesses[i]);
    ++result.fallbacks;
    result.iterations += other.descent.iterations;
    const double margin = request.trusted ? jumpMargin(config_, request, other.descent.pose) : 0.0;
    if (other.penalized_score > best.penalized_score + margin) best = other;
  }
  const Pose2& first_guess = request.initial_guesses.front();
  if (is_doubtful()) {
    // The yaw is found more reliably than the position, and the position changes less in a turn.
    const Candidate other =
        refine(map, request, Pose2(first_guess.x, first_guess.y, best.descent.pose.yaw));
    result.iterations += other.descent.iterations;
    if (other.penalized_score > best.penalized_score) best = other;
  }
  const bool jumps = (first_guess.inverse() * best.descent.pose).distance() > request.plausible_m;
  if ((best.fit.score < config_.search_score || jumps) && !request.trusted) {
    // An object that covers part of the view may mislead the coarse stages.
    const Candidate near = refine(map, request, first_guess, kLastStage);
    result.iterations += near.descent.iterations;
    const double margin = jumps ? jumpMargin(config_, request, best.descent.pose) : 0.0;
    if (near.penalized_score + margin > best.penalized_score) best = near;
  }
  const bool fits_poorly =
      best.fit.score < config_.search_score && (request.lost || !isWellConstrained(best.fit));
  if (fits_poorly || is_doubtful()) search(map, request, result, best);
  if (request.lost) {
    // The last descent began far away and may have ended before it converged.
    const Candidate closer = refine(map, request, best.descent.pose, kLastStage);
    result.iterations += closer.descent.iterations;
    if (closer.penalized_score > best.penalized_score) best = closer;
  }
  result.pose = best.descent.pose;
  result.converged = best.descent.converged;
  fillUncertainty(map, request.points, {kStageScales.back(), best.descent.at_pose, best.fit},
                  config_, result);
  fillStages(map, request.points, best.stages, config_.score_scale_m, result);
  return result;
}

void HybridMatcher::search(const Submap& map, const MatchRequest& request, MatchResult& result,
                           Candidate& best) const {
  result.searched = true;
  const Points points = request.lost ? thinned(request.points, kLostPoints) : request.points;
  std::vector<SearchWindow> windows = searchWindows(config_, request);
  if (request.lost) windows.erase(windows.begin(), windows.end() - 1);
  Pose2 center = request.last;
  if (request.yaw_known) center = Pose2(center.x, center.y, request.initial_guesses.front().yaw);
  SearchWindow searched{0.0, 0.0};
  for (const SearchWindow& window : windows) {
    // The surroundings of a pose outside of the window were not searched.
    if (best.fit.score >= config_.search_score &&
        isInside(searched, center.between(best.descent.pose)))
      break;
    searched = window;
    const SearchResult found = searchWindow(map.surface(), points, center, window,
                                            preferencesFor(request, config_.correlative));
    Candidate other = refine(map, request, found.pose);
    result.iterations += other.descent.iterations;
    // Of two jumps the better one is taken.
    const double margin = best.jumped ? 0.0 : jumpMargin(config_, request, other.descent.pose);
    if (other.penalized_score > best.penalized_score + margin) best = other;
  }
}

HybridMatcher::Candidate HybridMatcher::refine(const Submap& map, const MatchRequest& request,
                                               const Pose2& initial_guess,
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
    const Points& points = last ? request.points : few;
    const Eigen::Vector3f pull =
        Eigen::Vector3f::Constant(kPriorWeight * static_cast<float>(points.size()));
    result.descent = descend(
        pose, last ? config_.gauss_newton : coarse, pull,
        [&](const Pose2& at) { return linearizeDistance(map.surface(), points, at, scale); });
    pose = result.descent.pose;
    iterations += result.descent.iterations;
    result.stages[stage] = pose;
  }
  for (std::size_t stage = 0; stage < first_stage; ++stage) result.stages[stage] = pose;
  result.descent.iterations = iterations;
  result.fit = fitOf(map, request.points, pose, config_.score_scale_m);
  result.penalized_score = penalizedScore(request, result.fit, pose, config_.correlative);
  result.jumped = leftBasin(few, initial_guess, pose);
  return result;
}

std::vector<SearchWindow> searchWindows(const MatcherConfig& config, const MatchRequest& request) {
  std::vector<SearchWindow> windows = {config.near_window, config.wide_window};
  if (request.search_all_yaws) windows.push_back({config.wide_window.linear_m, kPi});
  for (SearchWindow& window : windows) {
    window.linear_m *= request.search_scale;
    if (!request.yaw_known) continue;
    window.angular_rad =
        std::min(window.angular_rad, std::max(kKnownYawWindow, request.yaw_error_rad));
  }
  return windows;
}

double jumpMargin(const MatcherConfig& config, const MatchRequest& request, const Pose2& pose) {
  const Pose2 jump = request.initial_guesses.front().inverse() * pose;
  const double ratio = std::max(1.0, jump.distance() / request.plausible_m);
  return config.jump_margin * ratio * ratio;
}

CorrelativeConfig preferencesFor(const MatchRequest& request, const CorrelativeConfig& config) {
  CorrelativeConfig result = config;
  result.linear_preference /= request.moved_scale;
  result.angular_preference /= request.moved_scale;
  return result;
}

double penalizedScore(const MatchRequest& request, const Fit& fit, const Pose2& pose,
                      const CorrelativeConfig& preferences) {
  const CorrelativeConfig config = preferencesFor(request, preferences);
  const Pose2 motion = request.last.inverse() * pose;
  return fit.score - config.linear_preference * motion.distance() -
         config.angular_preference * std::abs(motion.yaw);
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
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> normals(fit.normals);
  const Eigen::Vector2d weakest = normals.eigenvectors().col(0);
  // The part of kAlongWeight (SurfelField) is not a constraint.
  const double along = kAlongWeight / (1.0 + kAlongWeight);
  const double share = std::max(normals.eigenvalues()(0) - along, 0.0);
  result.constraint = share;
  result.degenerate = share < config.degenerate_share;
  result.covariance = covarianceOf(map, points, optimum, config, result.pose);
  const Eigen::Matrix2d across = optimum.at_pose.hessian.cast<double>().topLeftCorner<2, 2>();
  const double hessian_share =
      weakest.dot(across * weakest) / std::max(across.trace(), kLeastTrace);
  const double constrained = std::max(share, config.degenerate_share);
  result.covariance =
      stretched(result.covariance, weakest, std::sqrt(std::max(hessian_share / constrained, 1.0)));
  if (!result.degenerate) return;
  result.degenerate_direction = weakest;
  result.covariance.topLeftCorner<2, 2>() +=
      kUnconstrainedM * kUnconstrainedM * (weakest * weakest.transpose());
}

}  // namespace kestrel
