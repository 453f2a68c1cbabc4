#include "kestrel_slam/matching/correlative.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace kestrel_slam {
namespace {

constexpr int kMaxLikelihood = 255;
/// Blocks of 2^3 = 8 cells at the top: for windows of a metre a few of them a direction.
constexpr int kMinLevels = 3;
/// Neighbours of the best pose whose scores make its covariance.
constexpr int kCovarianceRadius = 3;
/// How much of the likelihoods' logarithm one beam is worth: neighbouring beams see the same wall.
constexpr double kIndependentBeams = 30.0;
/// Points farther away than this many cells (100 m at 5 cm) take no part: the image around them all
/// would need more memory than there is.
constexpr float kMaxRangeCells = 2000.0F;

Points pointsInRange(const Points& points, float resolution) {
  Points result;
  result.reserve(points.size());
  for (const Eigen::Vector2f& p : points) {
    if (p.norm() <= kMaxRangeCells * resolution) result.push_back(p);  // NaN fails
  }
  return result;
}

/// The discretised window: what both searches and the covariance share.
class Grid {
 public:
  Grid(const SurfelField& surface, const Points& points, const Pose2& center,
       const SearchWindow& window, const CorrelativeConfig& config)
      : points_(points), center_(center), config_(config), resolution_(surface.resolution()) {
    float range = 0.0F;
    for (const Eigen::Vector2f& p : points) range = std::max(range, p.norm());
    linear_steps_ = std::max(
        0, static_cast<int>(std::ceil(window.linear_m / static_cast<double>(resolution_) - 1e-6)));
    angular_step_ = std::max(config.min_angular_step_rad,
                             static_cast<double>(resolution_ / std::max(range, resolution_)));
    angular_steps_ =
        std::max(0, static_cast<int>(std::ceil(window.angular_rad / angular_step_ - 1e-6)));
    radius_ = range + resolution_ * static_cast<float>(linear_steps_ + 2 * kCovarianceRadius + 2);
  }

  int linearSteps() const { return linear_steps_; }
  int angularSteps() const { return angular_steps_; }
  float radius() const { return radius_; }

  /// Cells of the points, relative to the pyramid's corner, with the centre turned by step `k`.
  void rotate(int k, const Cell& corner, std::vector<Cell>& cells) const {
    const double theta = center_.theta + k * angular_step_;
    const auto c = static_cast<float>(std::cos(theta)), s = static_cast<float>(std::sin(theta));
    const auto x = static_cast<float>(center_.x), y = static_cast<float>(center_.y);
    const float inverse = 1.0F / resolution_;
    cells.clear();
    for (const Eigen::Vector2f& p : points_) {
      cells.push_back({floorToInt((x + c * p.x() - s * p.y()) * inverse) - corner.x,
                       floorToInt((y + s * p.x() + c * p.y()) * inverse) - corner.y});
    }
  }

  /// What the least motion inside a block costs; `size` cells a side from (dx, dy) on.
  double preference(int dx, int dy, int size, int k) const {
    const auto nearest = [size](int low) { return low > 0 ? low : std::min(0, low + size - 1); };
    return config_.linear_preference * static_cast<double>(resolution_) *
               std::hypot(nearest(dx), nearest(dy)) +
           config_.angular_preference * std::abs(k * angular_step_);
  }

  double score(int sum) const {
    return static_cast<double>(sum) /
           (static_cast<double>(kMaxLikelihood) * static_cast<double>(points_.size()));
  }

  Pose2 pose(int dx, int dy, int k) const {
    return {center_.x + dx * static_cast<double>(resolution_),
            center_.y + dy * static_cast<double>(resolution_), center_.theta + k * angular_step_};
  }

 private:
  const Points& points_;
  Pose2 center_;
  CorrelativeConfig config_;
  float resolution_;
  int linear_steps_, angular_steps_;
  double angular_step_;
  float radius_;
};

int sumAt(const LikelihoodPyramid& pyramid, int level, const std::vector<Cell>& cells, int dx,
          int dy) {
  int sum = 0;
  for (const Cell& cell : cells) sum += pyramid.at(level, cell.x + dx, cell.y + dy);
  return sum;
}

/// A block of translations at one angle and the bound of its score.
struct Block {
  double bound;
  int k, dx, dy, level;
};

struct Best {
  double preferred = -1e9;
  double score = 0.0;
  int k = 0, dx = 0, dy = 0;
};

class BranchAndBound {
 public:
  BranchAndBound(const Grid& grid, const LikelihoodPyramid& pyramid)
      : grid_(grid), pyramid_(pyramid), top_(pyramid.levels() - 1) {
    const int angles = 2 * grid.angularSteps() + 1;
    cells_.resize(static_cast<std::size_t>(angles));
    for (int k = -grid.angularSteps(); k <= grid.angularSteps(); ++k) {
      grid.rotate(k, pyramid.corner(), cells(k));
    }
  }

  Best run() {
    std::vector<Block> blocks;
    const int size = 1 << top_;
    for (int k = -grid_.angularSteps(); k <= grid_.angularSteps(); ++k) {
      for (int dy = -grid_.linearSteps(); dy <= grid_.linearSteps(); dy += size) {
        for (int dx = -grid_.linearSteps(); dx <= grid_.linearSteps(); dx += size) {
          blocks.push_back(makeBlock(k, dx, dy, top_));
        }
      }
    }
    std::stable_sort(blocks.begin(), blocks.end(),
                     [](const Block& a, const Block& b) { return a.bound > b.bound; });
    for (const Block& block : blocks) descend(block);
    return best_;
  }

 private:
  std::vector<Cell>& cells(int k) {
    return cells_[static_cast<std::size_t>(k + grid_.angularSteps())];
  }

  Block makeBlock(int k, int dx, int dy, int level) {
    const int sum = sumAt(pyramid_, level, cells(k), dx, dy);
    return {grid_.score(sum) - grid_.preference(dx, dy, 1 << level, k), k, dx, dy, level};
  }

  void descend(const Block& block) {
    if (block.bound <= best_.preferred) return;
    if (block.level == 0) {
      const double preference = grid_.preference(block.dx, block.dy, 1, block.k);
      best_ = {block.bound, block.bound + preference, block.k, block.dx, block.dy};
      return;
    }
    const int half = 1 << (block.level - 1);
    std::array<Block, 4> children{};
    std::size_t count = 0;
    for (const int dy : {block.dy, block.dy + half}) {
      for (const int dx : {block.dx, block.dx + half}) {
        if (dx > grid_.linearSteps() || dy > grid_.linearSteps()) continue;
        children[count++] = makeBlock(block.k, dx, dy, block.level - 1);
      }
    }
    std::stable_sort(children.begin(), children.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Block& a, const Block& b) { return a.bound > b.bound; });
    for (std::size_t i = 0; i < count; ++i) descend(children[i]);
  }

  const Grid& grid_;
  const LikelihoodPyramid& pyramid_;
  int top_;
  std::vector<std::vector<Cell>> cells_;
  Best best_;
};

/// Mean and covariance of the poses around the best one, weighted by their likelihood (Olson
/// eq. 5-7).
void fillMoments(const Grid& grid, const LikelihoodPyramid& pyramid, const Best& best,
                 SearchResult& result) {
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  double total = 0.0;
  const Pose2 at_best = grid.pose(best.dx, best.dy, best.k);
  std::vector<Cell> cells;
  for (int k = best.k - kCovarianceRadius; k <= best.k + kCovarianceRadius; ++k) {
    grid.rotate(k, pyramid.corner(), cells);
    for (int dy = best.dy - kCovarianceRadius; dy <= best.dy + kCovarianceRadius; ++dy) {
      for (int dx = best.dx - kCovarianceRadius; dx <= best.dx + kCovarianceRadius; ++dx) {
        const double score = grid.score(sumAt(pyramid, 0, cells, dx, dy));
        const double weight = std::exp(kIndependentBeams * (score - best.score));
        const Pose2 pose = grid.pose(dx, dy, k);
        const Eigen::Vector3d d(pose.x - at_best.x, pose.y - at_best.y,
                                normalizeAngle(pose.theta - at_best.theta));
        total += weight;
        first += weight * d;
        second += weight * d * d.transpose();
      }
    }
  }
  first /= total;
  result.mean = Pose2(at_best.x + first.x(), at_best.y + first.y(), at_best.theta + first.z());
  result.covariance = second / total - first * first.transpose();
}

SearchResult resultOf(const Grid& grid, const LikelihoodPyramid& pyramid, const Best& best) {
  SearchResult result;
  result.pose = grid.pose(best.dx, best.dy, best.k);
  result.score = best.score;
  result.preferred = best.preferred;
  fillMoments(grid, pyramid, best, result);
  return result;
}

SearchResult nothingAt(const Pose2& center) {
  SearchResult result;
  result.pose = result.mean = center;
  return result;
}

}  // namespace

LikelihoodPyramid::LikelihoodPyramid(const SurfelField& surface, const Eigen::Vector2f& center,
                                     float radius_m, float sigma_m, int levels) {
  const float resolution = surface.resolution();
  const int radius = static_cast<int>(std::ceil(radius_m / resolution)) + (1 << (levels - 1));
  side_ = 2 * radius + 1;
  corner_ = {floorToInt(center.x() / resolution) - radius,
             floorToInt(center.y() / resolution) - radius};
  const std::size_t size = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  levels_.assign(static_cast<std::size_t>(levels), std::vector<std::uint8_t>(size, 0));
  rasterise(surface, sigma_m);
  for (std::size_t k = 1; k < levels_.size(); ++k) {
    // The window of 2^k is four windows of 2^(k-1); beyond the border there is nothing.
    const int half = 1 << (k - 1);
    const std::vector<std::uint8_t>& fine = levels_[k - 1];
    std::vector<std::uint8_t>& coarse = levels_[k];
    for (int y = 0; y < side_; ++y) {
      const std::uint8_t* a = fine.data() + index(0, y);
      const std::uint8_t* b = fine.data() + index(0, std::min(y + half, side_ - 1));
      std::uint8_t* out = coarse.data() + index(0, y);
      for (int x = 0; x < side_ - half; ++x) {
        out[x] = std::max(std::max(a[x], a[x + half]), std::max(b[x], b[x + half]));
      }
      for (int x = side_ - half; x < side_; ++x) out[x] = std::max(a[x], b[x]);
    }
  }
}

void LikelihoodPyramid::rasterise(const SurfelField& surface, float sigma_m) {
  const float resolution = surface.resolution();
  const float scale = -0.5F / (sigma_m * sigma_m);
  for (int y = 0; y < side_; ++y) {
    for (int x = 0; x < side_; ++x) {
      const Eigen::Vector2f center =
          (Eigen::Vector2f(static_cast<float>(corner_.x + x), static_cast<float>(corner_.y + y))
               .array() +
           0.5F) *
          resolution;
      const Surfel* surfel = surface.nearest(center);
      if (surfel == nullptr) continue;
      const float likelihood = std::exp(scale * (center - surfel->mean).squaredNorm());
      levels_[0][index(x, y)] =
          static_cast<std::uint8_t>(std::lround(likelihood * static_cast<float>(kMaxLikelihood)));
    }
  }
}

SearchResult searchWindow(const SurfelField& surface, const Points& points, const Pose2& center,
                          const SearchWindow& window, const CorrelativeConfig& config) {
  const Points near = pointsInRange(points, surface.resolution());
  if (near.empty()) return nothingAt(center);
  const Grid grid(surface, near, center, window, config);
  int levels = kMinLevels + 1;
  while ((1 << levels) < grid.linearSteps()) ++levels;
  const LikelihoodPyramid pyramid(surface, center.translation().cast<float>(), grid.radius(),
                                  static_cast<float>(config.sigma_m), levels);
  return resultOf(grid, pyramid, BranchAndBound(grid, pyramid).run());
}

SearchResult searchWindowBruteForce(const SurfelField& surface, const Points& points,
                                    const Pose2& center, const SearchWindow& window,
                                    const CorrelativeConfig& config) {
  const Points near = pointsInRange(points, surface.resolution());
  if (near.empty()) return nothingAt(center);
  const Grid grid(surface, near, center, window, config);
  const LikelihoodPyramid pyramid(surface, center.translation().cast<float>(), grid.radius(),
                                  static_cast<float>(config.sigma_m), 1);
  Best best;
  std::vector<Cell> cells;
  for (int k = -grid.angularSteps(); k <= grid.angularSteps(); ++k) {
    grid.rotate(k, pyramid.corner(), cells);
    for (int dy = -grid.linearSteps(); dy <= grid.linearSteps(); ++dy) {
      for (int dx = -grid.linearSteps(); dx <= grid.linearSteps(); ++dx) {
        const double score = grid.score(sumAt(pyramid, 0, cells, dx, dy));
        const double preferred = score - grid.preference(dx, dy, 1, k);
        if (preferred > best.preferred) best = {preferred, score, k, dx, dy};
      }
    }
  }
  return resultOf(grid, pyramid, best);
}

}  // namespace kestrel_slam
