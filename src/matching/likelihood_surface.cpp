// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/likelihood_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "surface_sampler.h"
#include "window_sums.h"

namespace kestrel {
namespace {

/// Number of independent beams. The other beams hit the same walls.
constexpr double kIndependentBeams = 30.0;
constexpr double kMostPoses = 50e6;

/// A pose with a score this much below the best one has less than a millionth of its weight.
constexpr double kNegligible = -0.5;

double weightOf(float score, float best) {
  const double difference = static_cast<double>(score - best);
  return difference < kNegligible ? 0.0 : std::exp(kIndependentBeams * difference);
}

/// Weighted sums over the poses of a row: of 1, dx and dx², and of 1 over the two end poses.
struct RowSums {
  double total = 0.0, x = 0.0, xx = 0.0, ends = 0.0;

  RowSums(const float* scores, int steps, float best) {
    for (int dx = -steps; dx <= steps; ++dx) {
      const double weight = weightOf(scores[dx + steps], best);
      total += weight;
      x += weight * dx;
      xx += weight * (dx * dx);
      if (std::abs(dx) == steps) ends += weight;
    }
  }
};

}  // namespace

LikelihoodSurface sampleAround(const SearchGrid& grid, const LikelihoodImage& image,
                               const GridPose& center, int linear_steps, int angular_steps) {
  LikelihoodSurface surface;
  surface.center = grid.pose(center);
  surface.step_m = grid.resolution();
  surface.step_rad = grid.angularStep();
  surface.linear_steps = linear_steps;
  surface.angular_steps = angular_steps;
  const int side = surface.side(), count = grid.pointCount();
  const Windows windows{0, center.dx - linear_steps, center.dy - linear_steps, side, side};
  std::vector<PointCell> points(static_cast<std::size_t>(count));
  std::vector<int> sums;
  for (int k = -angular_steps; k <= angular_steps; ++k) {
    grid.rotate(center.k + k, 0, count, image.box(), points.data());
    sums.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
    for (int i = 0; i < count; i += kChunkPoints) {
      addWindows(image, windows, points.data() + i, std::min(kChunkPoints, count - i), sums.data());
    }
    for (const int sum : sums) surface.score.push_back(static_cast<float>(grid.score(sum)));
  }
  return surface;
}

LikelihoodSurface sampleLikelihood(const SurfelField& surface, const Points& points,
                                   const Pose2& center, const SearchWindow& window,
                                   const CorrelativeConfig& config) {
  const SearchGrid grid(surface, points, center, window, config);
  if (grid.pointCount() == 0) return LikelihoodSurface();
  const double side = 2.0 * grid.linearSteps() + 1.0;
  if (side * side * (2.0 * grid.angularSteps() + 1.0) > kMostPoses) {
    throw std::invalid_argument("likelihood surface: a window of ±" +
                                std::to_string(window.linear_m) + " m and ±" +
                                std::to_string(window.angular_rad) +
                                " rad has more than 50 million poses; choose a smaller one");
  }
  const LikelihoodImage image(surface, grid, 0, config.sigma_m, 1);
  return sampleAround(grid, image, GridPose(), grid.linearSteps(), grid.angularSteps());
}

std::vector<float> bestOverYaws(const LikelihoodSurface& surface) {
  const auto size = static_cast<std::ptrdiff_t>(surface.side()) * surface.side();
  std::vector<float> best(static_cast<std::size_t>(surface.score.empty() ? 0 : size), 0.0F);
  for (std::size_t i = 0; i < surface.score.size(); ++i) {
    float& cell = best[i % best.size()];
    cell = std::max(cell, surface.score[i]);
  }
  return best;
}

PoseMoments momentsOf(const LikelihoodSurface& surface) {
  const float best = *std::max_element(surface.score.begin(), surface.score.end());
  const int steps = surface.linear_steps;
  double total = 0.0, linear_border = 0.0, angular_border = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int k = -surface.angular_steps; k <= surface.angular_steps; ++k) {
    for (int dy = -steps; dy <= steps; ++dy) {
      const RowSums row(&surface.score[surface.index(-steps, dy, k)], steps, best);
      const Eigen::Vector2d other(dy, k);
      total += row.total;
      first += Eigen::Vector3d(row.x, row.total * dy, row.total * k);
      second(0, 0) += row.xx;
      second.bottomLeftCorner<2, 1>() += row.x * other;
      second.bottomRightCorner<2, 2>() += row.total * other * other.transpose();
      linear_border += std::abs(dy) == steps ? row.total : row.ends;
      if (std::abs(k) == surface.angular_steps) angular_border += row.total;
    }
  }
  second.topRightCorner<1, 2>() = second.bottomLeftCorner<2, 1>().transpose();
  first /= total;
  const Eigen::DiagonalMatrix<double, 3> unit(surface.step_m, surface.step_m, surface.step_rad);
  PoseMoments moments;
  moments.mean = addOffset(surface.center, unit * first);
  moments.covariance = unit * (second / total - first * first.transpose()) * unit;
  moments.linear_border = linear_border / total;
  moments.angular_border = angular_border / total;
  return moments;
}

}  // namespace kestrel
