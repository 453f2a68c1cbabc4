// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/matcher.h"

#include <stdexcept>

#include "hybrid_matcher.h"
#include "icp_matcher.h"
#include "kestrel_slam/matching/fit.h"
#include "progressive_matcher.h"

namespace kestrel {
namespace {

/// Gauss-Newton on the interpolated occupancy at 20, 10 and 5 cm [Kohlbrecher 2011, eq. 7-14],
/// iterated to convergence on each level.
class GaussNewtonMatcher : public Matcher {
 public:
  explicit GaussNewtonMatcher(const MatcherConfig& config) : config_(config) {}

  MatchResult match(const Submap& map, const MatchRequest& request) const override {
    static_assert(OccupancyGrid::kLevels == kMatchStages, "one stage per level");
    constexpr float kResidualScale = 0.5F;  // Cauchy scale of 1 - M in [0, 1]
    MatchResult result;
    Descent descent;
    std::array<Pose2, kMatchStages> poses;
    descent.pose = request.initial_guesses.front();
    for (std::size_t stage = 0; stage < kMatchStages; ++stage) {
      const int level = OccupancyGrid::kLevels - 1 - static_cast<int>(stage);
      descent = descend(
          descent.pose, config_.gauss_newton, Eigen::Vector3f::Zero(), [&](const Pose2& pose) {
            return linearizeOccupancy(map.grid(), level, request.points, pose, kResidualScale);
          });
      result.iterations += descent.iterations;
      poses[stage] = descent.pose;
    }
    result.pose = descent.pose;
    result.converged = descent.converged;
    // The residuals 1 - M have no unit. Therefore the covariance is computed from the distances.
    const Fit fit = fitOf(map, request.points, result.pose, config_.score_scale_m);
    const auto scale = static_cast<float>(config_.score_scale_m);
    const NormalEquations distances =
        linearizeDistance(map.surface(), request.points, result.pose, scale);
    fillUncertainty(map, request.points, {scale, distances, fit}, config_, result);
    fillStages(map, request.points, poses, config_.score_scale_m, result);
    return result;
  }

 private:
  MatcherConfig config_;
};

/// Exhaustive search [MAV SLAM 2013, eq. 3; Olson 2009] of the window around the prediction. The
/// pose is the mean of the likelihood surface around the best pose, the covariance is that of this
/// surface.
class CorrelativeMatcher : public Matcher {
 public:
  explicit CorrelativeMatcher(const MatcherConfig& config) : config_(config) {}

  MatchResult match(const Submap& map, const MatchRequest& request) const override {
    SearchWindow window = config_.near_window;
    window.linear_m *= request.search_scale;
    if (request.search_all_yaws) window.angular_rad = kPi;
    const SearchResult found =
        searchWindow(map.surface(), request.points, request.initial_guesses.front(), window,
                     config_.correlative);
    MatchResult result;
    result.searched = true;
    result.iterations = 1;
    result.converged = found.score > 0.0;
    result.pose = found.mean;
    const Fit fit = fitOf(map, request.points, result.pose, config_.score_scale_m);
    const auto scale = static_cast<float>(config_.score_scale_m);
    const NormalEquations distances =
        linearizeDistance(map.surface(), request.points, result.pose, scale);
    fillUncertainty(map, request.points, {scale, distances, fit}, config_, result);
    result.covariance = found.covariance;
    fillStages(map, request.points, {found.pose, found.pose, found.mean}, config_.score_scale_m,
               result);
    return result;
  }

 private:
  MatcherConfig config_;
};

}  // namespace

const std::vector<std::string>& matcherNames() {
  static const std::vector<std::string> names = {"gauss_newton", "correlative", "progressive",
                                                 "icp", "hybrid"};
  return names;
}

std::unique_ptr<Matcher> makeMatcher(const MatcherConfig& config) {
  if (config.method == "hybrid") return std::make_unique<HybridMatcher>(config);
  if (config.method == "gauss_newton") return std::make_unique<GaussNewtonMatcher>(config);
  if (config.method == "correlative") return std::make_unique<CorrelativeMatcher>(config);
  if (config.method == "progressive") return std::make_unique<ProgressiveMatcher>(config);
  if (config.method == "icp") return std::make_unique<IcpMatcher>(config);
  std::string known;
  for (const std::string& name : matcherNames()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument("matcher = " + config.method + ": must be one of " + known);
}

SubmapOptions submapOptions(const MatcherConfig& config) {
  SubmapOptions options;
  if (config.method != "icp") return options;
  if (config.icp.reference == "last_scans") {
    options.kept_scans = static_cast<std::size_t>(config.icp.last_scans);
  }
  options.stitching = config.icp.stitching;
  return options;
}

}  // namespace kestrel
