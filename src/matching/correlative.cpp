// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/correlative.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "branch_and_bound.h"
#include "likelihood_image.h"
#include "search_grid.h"
#include "surface_sampler.h"

namespace kestrel {
namespace {

/// The mean is computed from this many steps around the best pose.
constexpr int kMeanRadius = 3;
/// For the covariance the region is doubled until its border holds at most this share of the
/// likelihood, up to a maximum number of steps (along a corridor the likelihood does not decrease).
constexpr double kBorderShare = 0.05;
constexpr int kCovarianceRadius = 12;

/// Fills mean and covariance. The mean only uses the nearest poses: a second peak makes the pose
/// uncertain, but the mean must not be between the two peaks.
void fillMoments(const SearchGrid& grid, const LikelihoodImage& image, const GridPose& best,
                 SearchResult& result) {
  int linear = kMeanRadius, angular = kMeanRadius;
  PoseMoments moments = momentsOf(sampleAround(grid, image, best, linear, angular));
  result.mean = moments.mean;
  for (;;) {
    const bool wider = moments.linear_border > kBorderShare && linear < kCovarianceRadius;
    const bool turned = moments.angular_border > kBorderShare && angular < kCovarianceRadius;
    if (!wider && !turned) break;
    if (wider) linear *= 2;
    if (turned) angular *= 2;
    moments = momentsOf(sampleAround(grid, image, best, linear, angular));
  }
  result.covariance = moments.covariance;
}

/// Sums of the likelihoods of all points for every (dx, dy) of the window at one angle, row by row,
/// without bounds. The search is tested against it.
class YawSums {
 public:
  YawSums(const SearchGrid& grid, const LikelihoodImage& image)
      : grid_(grid), image_(image), cells_(static_cast<std::size_t>(grid.pointCount())) {}

  const std::vector<int>& at(int k) {
    // Number of points whose sum fits into 16 bits.
    constexpr int kPoints = 0xFFFF / LikelihoodImage::kMax;
    const int steps = grid_.linearSteps(), side = 2 * steps + 1;
    sums_.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
    partial_.assign(sums_.size(), 0);
    grid_.rotate(k, 0, grid_.pointCount(), image_.box(), cells_.data());
    int added = 0;
    for (const PointCell& cell : cells_) {
      const std::uint8_t* likelihood = image_.at(0, cell.x - steps, cell.y - steps);
      std::uint16_t* sum = partial_.data();
      for (int y = 0; y < side; ++y, likelihood += image_.stride(), sum += side) {
        for (int x = 0; x < side; ++x) sum[x] = static_cast<std::uint16_t>(sum[x] + likelihood[x]);
      }
      if (++added % kPoints == 0) addPartial();
    }
    addPartial();
    return sums_;
  }

 private:
  void addPartial() {
    for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += partial_[i];
    std::fill(partial_.begin(), partial_.end(), std::uint16_t{0});
  }

  const SearchGrid& grid_;
  const LikelihoodImage& image_;
  std::vector<PointCell> cells_;
  std::vector<int> sums_;
  std::vector<std::uint16_t> partial_;  ///< sums of kPoints points
};

SearchResult resultOf(const SearchGrid& grid, const LikelihoodImage& image,
                      const ScoredPose& best) {
  SearchResult result;
  result.pose = grid.pose(best.at);
  result.score = best.score;
  result.penalized_score = best.penalized_score;
  fillMoments(grid, image, best.at, result);
  return result;
}

SearchResult emptyResult(const Pose2& center) {
  SearchResult result;
  result.pose = result.mean = center;
  return result;
}

}  // namespace

bool isNear(const ExcludedPoses& excluded, const Pose2& pose) {
  if (excluded.linear_m <= 0.0) return false;
  Eigen::Vector2d away = pose.translation() - excluded.pose.translation();
  away -= excluded.ignored_direction * excluded.ignored_direction.dot(away);
  return away.lpNorm<Eigen::Infinity>() < excluded.linear_m &&
         std::abs(normalizeAngle(pose.yaw - excluded.pose.yaw)) < excluded.angular_rad;
}

SearchResult searchWindow(const SurfelField& surface, const Points& points, const Pose2& center,
                          const SearchWindow& window, const CorrelativeConfig& config) {
  const SearchGrid grid(surface, points, center, window, config);
  if (grid.pointCount() == 0) return emptyResult(center);
  const LikelihoodImage image(surface, grid, kCovarianceRadius, config.sigma_m,
                              BranchAndBound::levelsFor(grid));
  return resultOf(grid, image, BranchAndBound(grid, image).run());
}

SearchResult searchWindowBruteForce(const SurfelField& surface, const Points& points,
                                    const Pose2& center, const SearchWindow& window,
                                    const CorrelativeConfig& config) {
  const SearchGrid grid(surface, points, center, window, config);
  if (grid.pointCount() == 0) return emptyResult(center);
  const LikelihoodImage image(surface, grid, kCovarianceRadius, config.sigma_m, 1);
  YawSums sums(grid, image);
  const int steps = grid.linearSteps();
  ScoredPose best;
  for (int k = -grid.angularSteps(); k <= grid.angularSteps(); ++k) {
    const int* sum = sums.at(k).data();
    for (int dy = -steps; dy <= steps; ++dy) {
      for (int dx = -steps; dx <= steps; ++dx, ++sum) {
        const double score = grid.score(*sum);
        const double penalized_score = score - grid.motionPenalty({k, dx, dy}, 1);
        if (penalized_score > best.penalized_score) best = {penalized_score, score, {k, dx, dy}};
      }
    }
  }
  return resultOf(grid, image, best);
}

}  // namespace kestrel
