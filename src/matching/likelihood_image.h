// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "reach_mask.h"
#include "search_grid.h"

namespace kestrel {

/// Likelihood of the cells that a search can reach, and its maxima over windows of 2^k × 2^k cells.
///
/// Only computed where points of the scan can be and where the surface has walls nearby. A row of
/// level k first holds the cells 0, 2^k, 2·2^k, …, then 1, 2^k + 1, … So adjacent windows are
/// neighbors in memory, and one instruction sums several of them.
class LikelihoodImage {
 public:
  /// The value of likelihood 1 in level 0 and in the coarser levels, where values are rounded up.
  static constexpr int kMax = 255;
  static constexpr int kCoarseMax = 63;
  /// Number of windows that may be read at once; the image has this many spare bytes at its end.
  static constexpr int kLanes = 16;

  /// For the motions of `grid` plus `margin` steps in every direction.
  LikelihoodImage(const SurfelField& surface, const SearchGrid& grid, int margin, double sigma_m,
                  int levels);

  int levels() const { return static_cast<int>(levels_.size()); }
  /// The box for SearchGrid::rotate. The likelihood is 0 for a point on its border after any
  /// motion.
  const CellBox& box() const { return box_; }
  /// Pointer to the maximum over [x, x + 2^level) × [y, y + 2^level), relative to the box. The next
  /// byte is the window at x + 2^level, and so on. For the next row of windows add 2^level *
  /// stride().
  const std::uint8_t* at(int level, int x, int y) const {
    const int column = x + pad_, phase = column & ((1 << level) - 1);
    return levels_[static_cast<std::size_t>(level)].data() +
           (static_cast<std::ptrdiff_t>(y + pad_) * stride_ + phase * (stride_ >> level) +
            (column >> level));
  }
  int stride() const { return stride_; }

  /// Converts a sum of values of a level to the unit of level 0, rounded up.
  static int likelihoodOf(int level, int sum) {
    return level == 0 ? sum : (sum * kMax + kCoarseMax - 1) / kCoarseMax;
  }

 private:
  void place(const CellBox& reached, int linear_steps);
  void rasterize(const SurfelField& surface, const ReachMask& reached, double sigma_m);
  void buildLevel(int level, const ReachMask& window_starts);
  void buildRow(int level, int y, int x0, int x1, std::vector<std::uint8_t>& pairs);
  /// Column and row in the image of a cell of the map.
  Cell inImage(const Cell& cell) const {
    return {cell.x - box_.low.x + pad_, cell.y - box_.low.y + pad_};
  }

  CellBox box_{};
  int pad_ = 0;     ///< cells around the box
  int stride_ = 0;  ///< cells in a row
  std::vector<std::vector<std::uint8_t>> levels_;
};

}  // namespace kestrel
