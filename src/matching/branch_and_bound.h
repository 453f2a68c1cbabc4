// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "likelihood_image.h"
#include "search_grid.h"

namespace kestrel {

/// A pose of the grid with its score.
struct ScoredPose {
  double penalized_score = -1e9;  ///< the score minus the penalty of the motion
  double score = 0.0;
  GridPose at;
};

/// Whether `a` is better than `b`. If the scores are equal, the order is that of k, dy, dx.
inline bool isBetter(const ScoredPose& a, const ScoredPose& b) {
  if (a.penalized_score != b.penalized_score) return a.penalized_score > b.penalized_score;
  if (a.at.k != b.at.k) return a.at.k < b.at.k;
  return a.at.dy != b.at.dy ? a.at.dy < b.at.dy : a.at.dx < b.at.dx;
}

/// Finds the best pose of a window without evaluating every pose. Blocks of poses that cannot be
/// better than the best one so far are skipped ([Olson 2009], with more levels and the most
/// promising blocks first).
///
/// The bound of a block is the sum, over the points, of the maximum over the cells that a point can
/// reach. First a sample of the points ranks the angles. Then the best blocks of some angles are
/// searched to get a good pose to compare with. Then the sums of all other angles are completed as
/// far as needed.
class BranchAndBound {
 public:
  BranchAndBound(const SearchGrid& grid, const LikelihoodImage& image);

  /// Number of levels that the image for the search of `grid` must have.
  static int levelsFor(const SearchGrid& grid);

  ScoredPose run();

 private:
  /// Poses [dx, dx + 2^level) × [dy, dy + 2^level) from `bound.at`. No pose is better than `bound`.
  struct Block {
    ScoredPose bound;
    int level;
  };
  /// A rectangle of blocks of one angle and level.
  struct Lattice {
    GridPose corner;
    int level, columns, rows;

    GridPose at(int row, int column) const {
      return {corner.k, corner.dx + column * (1 << level), corner.dy + row * (1 << level)};
    }
  };

  Lattice whole(int k) const {
    return {{k, -grid_.linearSteps(), -grid_.linearSteps()}, top_, side_, side_};
  }
  const PointCell* cells(int k);
  int* sumsOf(int k) {
    return sums_.data() + static_cast<std::ptrdiff_t>(k + grid_.angularSteps()) * side_ * side_;
  }
  std::vector<int> rankedAngles();
  void searchBestBlock(int k);
  bool addPoints(const Lattice& lattice, int first, int last, int* sums);
  bool keepRows(const Lattice& lattice, const int* sums, int rest, int& low, int& high) const;
  double boundOf(int level, int sum, int rest) const;
  void collect(const Lattice& lattice, const int* sums, std::vector<Block>& blocks) const;
  void expandAll(std::vector<Block>& blocks);
  void expand(const Block& block);

  const SearchGrid& grid_;
  const LikelihoodImage& image_;
  int top_;
  int side_;           ///< number of top-level blocks in a row of the window
  int sample_points_;  ///< number of points that rank the angles
  std::vector<std::vector<PointCell>> cells_;  ///< cells of the points, for every angle
  std::vector<int> sums_;                      ///< sums of all top-level blocks, angle by angle
  ScoredPose best_;
};

}  // namespace kestrel
