// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "likelihood_image.h"
#include "search_grid.h"

namespace kestrel {

/// A pose of the grid with what it is worth.
struct ScoredPose {
  double penalized_score = -1e9;  ///< the score less the cost of the motion
  double score = 0.0;
  GridPose at;
};

/// Whether `a` comes before `b`: the better one, of equal ones the first in the order of k, dy, dx.
inline bool isBetter(const ScoredPose& a, const ScoredPose& b) {
  if (a.penalized_score != b.penalized_score) return a.penalized_score > b.penalized_score;
  if (a.at.k != b.at.k) return a.at.k < b.at.k;
  return a.at.dy != b.at.dy ? a.at.dy < b.at.dy : a.at.dx < b.at.dx;
}

/// The best pose of a window without looking at every one: blocks of poses of which none can be
/// better than the best one so far are left out (E. Olson, "Real-time correlative scan matching",
/// ICRA 2009, with more levels, the most promising blocks first).
///
/// The bound of a block takes of every point the maximum over the cells that it can reach. A sample
/// of the points ranks the angles; a few blocks of the best are searched through, so that there is
/// a good pose to compare with; then the sums of all angles are completed as far as that is worth.
class BranchAndBound {
 public:
  BranchAndBound(const SearchGrid& grid, const LikelihoodImage& image);

  /// Levels that the image for the search of `grid` should have.
  static int levelsFor(const SearchGrid& grid);

  ScoredPose run();

 private:
  /// Poses [dx, dx + 2^level) × [dy, dy + 2^level) from `bound.at` on; none is better than `bound`.
  struct Block {
    ScoredPose bound;
    int level;
  };
  /// Blocks of one angle and level side by side.
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
  int side_;                                   ///< blocks of the top level in a row of the window
  int sample_points_;                          ///< the first points, which rank the angles
  std::vector<std::vector<PointCell>> cells_;  ///< of every angle
  std::vector<int> sums_;                      ///< of every block of the top level, angle by angle
  ScoredPose best_;
};

}  // namespace kestrel
