// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "search_grid.h"

namespace kestrel {

/// Which blocks of kSide × kSide cells the points of a scan can reach in a search.
class ReachMask {
 public:
  static constexpr int kShift = 4;
  static constexpr int kSide = 1 << kShift;
  static_assert(kShift <= kTileShift, "a block lies in one tile of the surface");

  /// Blocks needed for `cells` cells, wherever in its block the first one is.
  static constexpr int blocksFor(int cells) { return (cells + kSide - 1) >> kShift; }

  /// The blocks that hold a point at any angle of `grid` or `margin` angles more, and those from
  /// `before` blocks ahead of them to `after` behind them, in x and y.
  ReachMask(const SearchGrid& grid, int margin, int before, int after);

  /// Leaves only the blocks for which `keep(corner)` is true.
  template <typename Keep>
  void filter(Keep keep) {
    forEach([&](int x, int y) { row(y)[x] = keep(corner(x, y)) ? 1 : 0; });
  }
  /// Every block marks those from `before` ahead of it to `after` behind it, in x and y.
  void dilate(int before, int after);

  /// Calls `visit(x, y)` for every block of the mask.
  template <typename Visit>
  void forEach(Visit visit) const {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        if (row(y)[x] != 0) visit(x, y);
      }
    }
  }

  /// The cell at the lower left of a block.
  Cell corner(int x, int y) const { return {low_.x + x * kSide, low_.y + y * kSide}; }
  /// The smallest box around the mask; empty where the mask is.
  CellBox box() const;
  int height() const { return height_; }
  /// First and last + 1 block of a row; equal where there is none.
  std::pair<int, int> span(int y) const;

 private:
  std::uint8_t* row(int y) { return mask_.data() + static_cast<std::ptrdiff_t>(y) * width_; }
  const std::uint8_t* row(int y) const {
    return mask_.data() + static_cast<std::ptrdiff_t>(y) * width_;
  }

  Cell low_;
  int width_, height_;
  std::vector<std::uint8_t> mask_;
};

}  // namespace kestrel
