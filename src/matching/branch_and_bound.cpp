// SPDX-License-Identifier: BSD-3-Clause
#include "branch_and_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "window_sums.h"

namespace kestrel {
namespace {

/// Blocks of the top level have at least 4 × 4 cells (2^kMinTop), and a row of the window has at
/// most kMaxSide of them. Smaller blocks have tighter bounds, but there are more of them.
constexpr int kMinTop = 2;
constexpr int kMaxSide = 20;
/// A block is split into 4 × 4 blocks. The sums of a row fit into the vector lanes of one addition.
constexpr int kSplitLevels = 2;
/// The angles are ranked with one point out of this many.
constexpr int kSampleShare = 8;
/// For this many of the best angles, the most promising block is searched first.
constexpr std::size_t kFirstAngles = 16;

}  // namespace

int BranchAndBound::levelsFor(const SearchGrid& grid) {
  int top = kMinTop;
  while (((2 * grid.linearSteps()) >> top) + 1 > kMaxSide) ++top;
  return top + 1;
}

BranchAndBound::BranchAndBound(const SearchGrid& grid, const LikelihoodImage& image)
    : grid_(grid),
      image_(image),
      top_(image.levels() - 1),
      side_(((2 * grid.linearSteps()) >> top_) + 1),
      sample_points_(
          std::min(grid.pointCount(), std::max(grid.pointCount() / kSampleShare, kChunkPoints))),
      cells_(static_cast<std::size_t>(2 * grid.angularSteps() + 1)),
      sums_(cells_.size() * static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), 0) {}

ScoredPose BranchAndBound::run() {
  const std::vector<int> angles = rankedAngles();
  for (std::size_t i = 0; i < std::min(kFirstAngles, angles.size()); ++i) {
    searchBestBlock(angles[i]);
  }
  std::vector<Block> blocks;
  for (const int k : angles) {
    if (addPoints(whole(k), sample_points_, grid_.pointCount(), sumsOf(k))) {
      collect(whole(k), sumsOf(k), blocks);
    }
  }
  expandAll(blocks);
  return best_;
}

/// Sums the sample of the points for all angles. Returns the angles, highest sum first.
std::vector<int> BranchAndBound::rankedAngles() {
  std::vector<std::pair<int, int>> order;  // (negative highest sum, angle)
  for (int k = -grid_.angularSteps(); k <= grid_.angularSteps(); ++k) {
    addPoints(whole(k), 0, sample_points_, sumsOf(k));
    order.emplace_back(-*std::max_element(sumsOf(k), sumsOf(k) + side_ * side_), k);
  }
  std::sort(order.begin(), order.end());
  std::vector<int> angles;
  for (const auto& [sum, k] : order) angles.push_back(k);
  return angles;
}

void BranchAndBound::searchBestBlock(int k) {
  const auto best = std::max_element(sumsOf(k), sumsOf(k) + side_ * side_) - sumsOf(k);
  const int row = static_cast<int>(best) / side_, column = static_cast<int>(best) % side_;
  ScoredPose bound;
  bound.penalized_score = bound.score = 1.0;
  bound.at = whole(k).at(row, column);
  expand({bound, top_});
}

const PointCell* BranchAndBound::cells(int k) {
  std::vector<PointCell>& cells = cells_[static_cast<std::size_t>(k + grid_.angularSteps())];
  if (cells.empty()) {
    cells.resize(static_cast<std::size_t>(grid_.pointCount()));
    grid_.rotate(k, 0, grid_.pointCount(), image_.box(), cells.data());
  }
  return cells.data();
}

/// Adds the points [first, last) to the sums of the blocks. Returns false as soon as no block can
/// be better than the best pose. The sums of rows that cannot be better are left incomplete.
bool BranchAndBound::addPoints(const Lattice& lattice, int first, int last, int* sums) {
  const PointCell* points = cells(lattice.corner.k);
  int low = 0, high = lattice.rows;
  for (int i = first; i < last; i += kChunkPoints) {
    const int count = std::min(kChunkPoints, last - i);
    const GridPose corner = lattice.at(low, 0);
    addWindows(image_, {lattice.level, corner.dx, corner.dy, lattice.columns, high - low},
               points + i, count, sums + low * lattice.columns);
    if (!keepRows(lattice, sums, grid_.pointCount() - i - count, low, high)) return false;
  }
  return true;
}

/// Narrows the rows [low, high) to those with a block that can be better than the best pose,
/// assuming that the remaining `rest` points all fit. Returns false if there is none.
bool BranchAndBound::keepRows(const Lattice& lattice, const int* sums, int rest, int& low,
                              int& high) const {
  const auto is_worse = [&](int row) {
    const int* first = sums + row * lattice.columns;
    const int most = *std::max_element(first, first + lattice.columns);
    return boundOf(lattice.level, most, rest) < best_.penalized_score;
  };
  while (low < high && is_worse(low)) ++low;
  while (low < high && is_worse(high - 1)) --high;
  return low < high;
}

double BranchAndBound::boundOf(int level, int sum, int rest) const {
  return grid_.score(LikelihoodImage::likelihoodOf(level, sum) + rest * LikelihoodImage::kMax);
}

/// Appends the blocks that can be better than the best pose.
void BranchAndBound::collect(const Lattice& lattice, const int* sums,
                             std::vector<Block>& blocks) const {
  for (int row = 0; row < lattice.rows; ++row) {
    for (int column = 0; column < lattice.columns; ++column, ++sums) {
      const GridPose corner = lattice.at(row, column);
      if (corner.dx > grid_.linearSteps() || corner.dy > grid_.linearSteps()) continue;
      const double score = boundOf(lattice.level, *sums, 0);
      if (score < best_.penalized_score) continue;
      const ScoredPose bound{score - grid_.motionPenalty(corner, 1 << lattice.level), score,
                             corner};
      if (isBetter(bound, best_)) blocks.push_back({bound, lattice.level});
    }
  }
}

void BranchAndBound::expandAll(std::vector<Block>& blocks) {
  std::sort(blocks.begin(), blocks.end(),
            [](const Block& a, const Block& b) { return isBetter(a.bound, b.bound); });
  for (const Block& block : blocks) expand(block);
}

void BranchAndBound::expand(const Block& block) {
  if (!isBetter(block.bound, best_)) return;
  if (block.level == 0) {
    best_ = block.bound;
    return;
  }
  const int level = std::max(0, block.level - kSplitLevels), side = 1 << (block.level - level);
  const Lattice lattice{block.bound.at, level, side, side};
  std::array<int, (1 << kSplitLevels) * (1 << kSplitLevels)> sums{};
  if (!addPoints(lattice, 0, grid_.pointCount(), sums.data())) return;
  std::vector<Block> blocks;
  collect(lattice, sums.data(), blocks);
  expandAll(blocks);
}

}  // namespace kestrel
