// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "search_grid.h"

namespace kestrel {

/// The blocks of kSide × kSide cells that the points of a scan can reach in a search.
class ReachMask {
 public:
  static constexpr int kShift = 4;
  static constexpr int kSide = 1 << kShift;
  static_assert(kShift <= kTileShift, "a block lies in one tile of the surface");

  /// Number of blocks for `cells` cells, for any position of the first cell in its block.
  static constexpr int blocksFor(int cells) { return (cells + kSide - 1) >> kShift; }

  /// Blocks with a point at any angle of `grid` plus `margin` angles, extended by `before` blocks
  /// to the lower left and `after` blocks to the upper right.
  ReachMask(const SearchGrid& grid, int margin, int before, int after);

  /// Removes the blocks for which `keep(corner)` is false.
  template <typename Keep>
  void filter(Keep keep) {
    forEach([&](int x, int y) { row(y)[x] = keep(corner(x, y)) ? 1 : 0; });
  }
  /// Extends every block by `before` blocks to the lower left and `after` blocks to the upper
  /// right.
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

  /// The lower left cell of a block.
  Cell corner(int x, int y) const { return {low_.x + x * kSide, low_.y + y * kSide}; }
  /// The bounding box of the mask, empty if the mask is empty.
  CellBox box() const;
  int height() const { return height_; }
  /// First and last + 1 block of a row; equal if the row is empty.
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
