// SPDX-License-Identifier: BSD-3-Clause
#include "icp_matcher.h"

#include <algorithm>
#include <cmath>

#include "hybrid_matcher.h"
#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Maximum pair distance of the stages, relative to that of the first.
constexpr std::array<double, kMatchStages> kReachShares = {1.0, 0.4, 0.2};
constexpr std::size_t kLastIcpStage = kMatchStages - 1;
/// Maximum distance of the iterations from all initial guesses, m.
constexpr float kMaxDriftM = 1.0F;
/// Step between rotated initial guesses, rad. ICP converges from half of it.
constexpr double kTurnStep = 0.15;

}  // namespace

IcpMatcher::IcpMatcher(const MatcherConfig& config)
    : config_(config),
      to_lines_(config.icp.metric == "point_to_line"),
      reference_(submapOptions(config).kept_scans) {}

MatchResult IcpMatcher::match(const Submap& map, const MatchRequest& request) const {
  const Task task = taskOf(map, request);
  Candidate best =
      refine(task, request.initial_guesses.front(), request.trusted ? kLastIcpStage : 0);
  MatchResult result;
  result.iterations = best.iterations;
  for (std::size_t i = 1; i < request.initial_guesses.size() && best.fit.score < config_.good_score;
       ++i) {
    const Candidate other = refine(task, request.initial_guesses[i]);
    result.iterations += other.iterations;
    const double margin = request.trusted ? config_.jump_margin : 0.0;
    if (other.penalized_score > best.penalized_score + margin) best = other;
  }
  if (!request.yaw_known) tryRotated(task, best, result.iterations);
  result.pose = best.stages.back();
  result.converged = best.converged;
  const auto scale = static_cast<float>(config_.score_scale_m);
  const NormalEquations distances =
      linearizeDistance(map.surface(), request.points, result.pose, scale);
  fillUncertainty(map, request.points, {scale, distances, best.fit}, config_, result);
  fillStages(map, request.points, best.stages, config_.score_scale_m, result);
  return result;
}

IcpMatcher::Task IcpMatcher::taskOf(const Submap& map, const MatchRequest& request) const {
  Task task{map, request, thinned(request.points, kCoarsePoints), {}, nullptr};
  float range2 = 0.0F;
  for (const Eigen::Vector2f& point : request.points) {
    range2 = std::max(range2, point.squaredNorm());
  }
  task.area.extend(request.last.translation().cast<float>().eval());
  for (const Pose2& initial_guess : request.initial_guesses) {
    task.area.extend(initial_guess.translation().cast<float>().eval());
  }
  const auto grown = [](const Eigen::AlignedBox2f& box, float margin) {
    const Eigen::Vector2f m = Eigen::Vector2f::Constant(margin);
    return Eigen::AlignedBox2f(box.min() - m, box.max() + m);
  };
  task.area = grown(task.area, std::sqrt(range2) + kMaxDriftM);
  task.reference =
      reference_.around(map, grown(task.area, static_cast<float>(config_.icp.max_pair_distance_m)));
  return task;
}

/// Pairing fails after a large rotation that no initial guess predicts. Therefore the last pose is
/// rotated to both sides in increasing steps until the scan fits.
void IcpMatcher::tryRotated(const Task& task, Candidate& best, int& iterations) const {
  const MatchRequest& request = task.request;
  const double most = request.search_all_yaws ? kPi : config_.wide_window.angular_rad;
  for (double turn = kTurnStep; turn < most; turn += kTurnStep) {
    for (const double signed_turn : {turn, -turn}) {
      if (best.fit.score >= config_.search_score) return;
      const Candidate other = refine(task, request.last * Pose2(0.0, 0.0, signed_turn));
      iterations += other.iterations;
      if (other.penalized_score > best.penalized_score + config_.jump_margin) best = other;
    }
  }
}

IcpMatcher::Candidate IcpMatcher::refine(const Task& task, const Pose2& initial_guess,
                                         std::size_t first_stage) const {
  const IcpConfig& icp = config_.icp;
  Candidate result;
  std::vector<IcpPair> pairs;
  pairs.reserve(task.request.points.size());
  Pose2 pose = initial_guess;
  for (std::size_t stage = first_stage; stage < kMatchStages; ++stage) {
    const Points& points = stage == kLastIcpStage ? task.request.points : task.few;
    const auto reach = static_cast<float>(icp.max_pair_distance_m * kReachShares[stage]);
    result.converged = false;
    for (int i = 0; i < icp.max_iterations && !result.converged; ++i) {
      pairUp(task, points, pose, reach, pairs);
      rejectWorstPairs(pairs, icp.rejected_share);
      if (pairs.empty()) break;
      const Pose2 next = to_lines_ ? alignPointToLine(pairs, pose) : alignPointToPoint(pairs, pose);
      const Pose2 step = pose.inverse() * next;
      pose = next;
      ++result.iterations;
      result.converged = step.distance() < icp.min_step_m && std::abs(step.yaw) < icp.min_step_rad;
    }
    result.stages[stage] = pose;
  }
  std::fill_n(result.stages.begin(), first_stage, pose);
  result.fit = fitOf(task.map, task.request.points, pose, config_.score_scale_m);
  result.penalized_score = penalizedScore(task.request, result.fit, pose, config_.correlative);
  return result;
}

void IcpMatcher::pairUp(const Task& task, const Points& points, const Pose2& pose, float reach_m,
                        std::vector<IcpPair>& pairs) const {
  const auto c = static_cast<float>(std::cos(pose.yaw));
  const auto s = static_cast<float>(std::sin(pose.yaw));
  const auto x = static_cast<float>(pose.x), y = static_cast<float>(pose.y);
  pairs.clear();
  for (const Eigen::Vector2f& p : points) {
    const Eigen::Vector2f point(x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y());
    if (!task.area.contains(point)) continue;
    const WallPoint* partner = task.reference->nearest(point, reach_m);
    if (partner == nullptr) continue;
    const Eigen::Vector2f difference = point - partner->position;
    const float across = partner->normal.dot(difference);
    const bool line = to_lines_ && !partner->normal.isZero(0.0F);
    pairs.push_back(
        {p, partner->position, partner->normal, line ? across * across : difference.squaredNorm()});
  }
}

}  // namespace kestrel
