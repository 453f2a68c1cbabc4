// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "kestrel_slam/map/surfel_field.h"
#include "search_grid.h"

namespace kestrel {

/// A rough image of the walls: a pixel is a square of 2^shift × 2^shift cells of the map.
///
/// It is made from the occupied cells only, which are few compared to all cells. A pixel with a
/// wall has the value kWall, those beside it half of that. In layer n > 0 every pixel has the
/// maximum of layer 0 over 2^(n - 1) pixels in all directions, for points that are only known to
/// that accuracy.
class WallImage {
 public:
  static constexpr int kMostLayers = 5;
  static constexpr int kWall = 63;

  /// Covers the cells of `box`.
  WallImage(const SurfelField& surface, const CellBox& box, int shift, int layers);

  bool covers(const CellBox& box, int shift, int layers) const;
  /// The lower left cell of the image.
  Cell corner() const { return {low_.x * cellsPerPixel(), low_.y * cellsPerPixel()}; }
  int cellsPerPixel() const { return 1 << shift_; }
  int stride() const { return width_; }
  const std::uint8_t* layer(int n) const { return layers_[static_cast<std::size_t>(n)].get(); }
  /// Work to make an image of this size.
  static std::int64_t workFor(const CellBox& box, int shift, int layers);

 private:
  void mark(const Cell& tile_corner, const SurfelField::OccupiedRows& rows);
  template <int shift>
  void extend(const std::uint8_t* in, int pixels, std::uint8_t* buffer, std::uint8_t* out);
  std::ptrdiff_t placeOf(int column, int row) const {
    return static_cast<std::ptrdiff_t>(row) * width_ + column;
  }

  /// The columns [first, last) of a row.
  struct Span {
    int first, last;
  };

  CellBox box_;
  int shift_;
  Cell low_;  ///< in pixels
  int width_, height_;
  std::vector<Span> spans_;  ///< of every row: all other columns are zero
  std::vector<std::unique_ptr<std::uint8_t[]>> layers_;
};

}  // namespace kestrel
