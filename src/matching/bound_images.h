// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kestrel_slam/map/submap.h"

namespace kestrel {

/// Images of the likelihood of a whole map, and its maxima over squares of cells: upper bounds for
/// the poses of a block. Unknown space counts as kUnknown.
///
/// A cell of image n holds the maximum over the square of side(n) cells of which it is the lower
/// left corner. A row first holds the cells 0, 4, 8, …, then 1, 5, 9, …: so blocks beside each
/// other are neighbors in memory.
class BoundImages {
 public:
  static constexpr int kLevels = 3;  ///< blocks of 4 × 4, 2 × 2 and 1 × 1 poses
  static constexpr std::array<int, 11> kSides = {1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20};
  static constexpr int kMax = 63;         ///< the value of likelihood 1
  static constexpr int kUnknown = 16;     ///< the value of unknown space: kUnknownScore
  static constexpr int kTileBlocks = 16;  ///< blocks of the coarsest level in a row of a tile
  static constexpr int kTileCells = 4 * kTileBlocks;

  explicit BoundImages(const Submap& map);

  /// Size of a cell, m. In large maps it is larger than that of the map.
  double cell() const { return cell_m_; }
  /// Place of the corner of cell (0, 0) in the map, m.
  const Eigen::Vector2d& corner() const { return corner_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// The image with the smallest squares that have at least this side.
  static int imageFor(int side);

  /// Whether an image has this cell. If not, it is unknown.
  bool contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }
  const std::uint8_t* at(int image, int x, int y) const {
    return images_.data() + static_cast<std::ptrdiff_t>(image) * image_size_ +
           static_cast<std::ptrdiff_t>(offset(x, y));
  }
  /// The values of kTileBlocks cells, from (x, y) on, 4 apart; or nullptr if they reach out of the
  /// image: then all are unknown, because the image has a margin.
  const std::uint8_t* stripAt(int image, int x, int y) const {
    const bool inside = static_cast<unsigned>(x) < static_cast<unsigned>(width_ - kTileCells + 4) &&
                        static_cast<unsigned>(y) < static_cast<unsigned>(height_);
    return inside ? at(image, x, y) : nullptr;
  }
  /// For points whose cells are all in the images: the values of stripAt() for a point are at
  /// rows(x, y) + place, where (x, y) is the pose and `place` is placeFor() of the point. It holds
  /// for all poses with the same x % 4.
  const std::uint8_t* rows(int x, int y) const {
    return images_.data() + static_cast<std::ptrdiff_t>(y) * width_ + (x >> 2);
  }
  std::int32_t placeFor(int image, int x, int y, int phase) const {
    const int column = phase + x;
    return image * image_size_ + y * width_ + (column & 3) * (width_ >> 2) + (column >> 2);
  }
  /// Whether a point that is from `low` to `high` relative to the pose is in the images in all
  /// lanes.
  bool containsStrip(const Cell& low, const Cell& high, int x, int y) const {
    return x + low.x >= 0 && y + low.y >= 0 && x + high.x < width_ - kTileCells + 4 &&
           y + high.y < height_;
  }
  /// The likelihood in a cell.
  int likelihood(int x, int y) const { return valueAt(0, x, y); }
  int valueAt(int image, int x, int y) const {
    return contains(x, y) ? *at(image, x, y) : kUnknown;
  }

  /// Tiles of blocks with a pose in free space, by their first cell.
  struct Tile {
    int x, y;
  };
  const std::vector<Tile>& tiles() const { return tiles_; }
  /// Whether a vehicle can be in the block of 4 × 4 cells from (x, y) on.
  bool isFree(int x, int y) const {
    return free_[static_cast<std::size_t>(y / 4) * static_cast<std::size_t>(width_ / 4) +
                 static_cast<std::size_t>(x / 4)] != 0;
  }
  std::size_t memoryBytes() const;

 private:
  using Bytes = std::vector<std::uint8_t>;

  std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>((x & 3) * (width_ >> 2) + (x >> 2));
  }
  void place(const Submap& map, const MapSnapshot& known);
  void rasterize(const Submap& map, Bytes& likelihood) const;
  void markUnknown(const MapSnapshot& known, Bytes& likelihood) const;
  void markFree(const MapSnapshot& known);
  Bytes maxima(const Bytes& likelihood, int side) const;
  void addSorted(const Bytes& image);

  double cell_m_ = 0.05;
  int shift_ = 0;  ///< a cell has 2^shift × 2^shift cells of the map
  Cell low_{};     ///< the cell of the map at the corner
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  int width_ = 0, height_ = 0;
  Bytes images_;  ///< one after the other
  int image_size_ = 0;
  std::vector<std::uint8_t> free_;
  std::vector<Tile> tiles_;
};

}  // namespace kestrel
