// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "kestrel_slam/map/memory_budget.h"

namespace kestrel {

/// Index of a square cell: [x, x + 1) × [y, y + 1) in units of the resolution.
struct Cell {
  int x = 0;
  int y = 0;
};
inline bool operator==(const Cell& a, const Cell& b) { return a.x == b.x && a.y == b.y; }

/// Largest integer not above `value`. Faster than std::floor without special compiler flags.
inline int floorToInt(float value) {
  const int truncated = static_cast<int>(value);
  return truncated - static_cast<int>(value < static_cast<float>(truncated));
}

/// Side of a tile in cells, a power of two.
constexpr int kTileShift = 5;
constexpr int kTileSide = 1 << kTileShift;
constexpr int kTileCells = kTileSide * kTileSide;

/// Offset of a cell within its tile, row-major.
inline std::size_t offsetInTile(const Cell& cell) {
  constexpr unsigned kMask = kTileSide - 1U;
  return (static_cast<std::size_t>(static_cast<unsigned>(cell.y) & kMask) << kTileShift) |
         (static_cast<unsigned>(cell.x) & kMask);
}

/// Four integers in one vector register: a vector type of GCC and Clang.
using FourInts = std::int32_t __attribute__((vector_size(16)));

/// The same as an array.
inline std::array<std::int32_t, 4> arrayOf(const FourInts& values) {
  std::array<std::int32_t, 4> result;
  std::memcpy(result.data(), &values, sizeof(values));
  return result;
}

/// Offsets of four cells within their tiles.
inline FourInts offsetsInTile(const FourInts& x, const FourInts& y) {
  constexpr int kMask = kTileSide - 1;
  return (y & kMask) << kTileShift | (x & kMask);
}

/// A plane of square tiles that are allocated when they are written.
///
/// The index is a dense rectangle around the tiles in use, so a look-up takes two comparisons and
/// two loads. Tiles and index together stay below a memory limit; a write that would exceed it is
/// refused.
template <typename Tile>
class TileMap {
 public:
  /// The budget may be shared with other parts of the map.
  explicit TileMap(SharedBudget budget) : budget_(std::move(budget)) {}
  explicit TileMap(std::size_t limit_bytes)
      : TileMap(std::make_shared<MemoryBudget>(limit_bytes)) {}

  /// The tile of a cell, or nullptr if it does not exist. Any coordinates are allowed.
  const Tile* find(const Cell& cell) const {
    const unsigned column = static_cast<unsigned>((cell.x >> kTileShift) - first_x_);
    const unsigned row = static_cast<unsigned>((cell.y >> kTileShift) - first_y_);
    if (column >= width_ || row >= height_) return nullptr;
    return index_[static_cast<std::size_t>(row) * width_ + column].get();
  }
  Tile* find(const Cell& cell) { return const_cast<Tile*>(std::as_const(*this).find(cell)); }

  /// Finds the slots of the tiles of four cells. Returns false if one of them is outside of the
  /// index, where no tile is.
  bool findSlots(const FourInts& x, const FourInts& y, FourInts& slots) const {
    const FourInts columns = (x >> kTileShift) - first_x_, rows = (y >> kTileShift) - first_y_;
    const FourInts columns_left = static_cast<int>(width_) - 1 - columns;
    const FourInts rows_left = static_cast<int>(height_) - 1 - rows;
    slots = rows * static_cast<int>(width_) + columns;
    // The sign bit is set where a cell is outside.
    const FourInts outside = columns | rows | columns_left | rows_left;
    std::array<std::uint64_t, 2> halves;
    std::memcpy(halves.data(), &outside, sizeof(outside));
    return ((halves[0] | halves[1]) & 0x8000000080000000U) == 0U;
  }
  /// The tile in a slot of findSlots, or nullptr if it does not exist.
  const Tile* inSlot(std::size_t slot) const { return index_[slot].get(); }

  /// The tile of a cell, allocated if needed; nullptr if that would exceed the limit.
  Tile* obtain(const Cell& cell) {
    if (Tile* tile = find(cell)) return tile;
    if (!budget_->take(sizeof(Tile))) return nullptr;
    if (!cover(cell)) {
      budget_->giveBack(sizeof(Tile));
      return nullptr;
    }
    const std::size_t column = static_cast<std::size_t>((cell.x >> kTileShift) - first_x_);
    const std::size_t row = static_cast<std::size_t>((cell.y >> kTileShift) - first_y_);
    std::unique_ptr<Tile>& slot = index_[row * width_ + column];
    slot = std::make_unique<Tile>();
    ++tile_count_;
    return slot.get();
  }

  void clear() {
    budget_->giveBack(memoryBytes());
    index_.clear();
    first_x_ = first_y_ = 0;
    width_ = height_ = 0;
    tile_count_ = 0;
  }

  std::size_t limitBytes() const { return budget_->limit(); }
  std::size_t tileCount() const { return tile_count_; }
  std::size_t memoryBytes() const {
    return tile_count_ * sizeof(Tile) + index_.size() * sizeof(std::unique_ptr<Tile>);
  }

  /// Calls `visit(lower_left_cell, tile)` for every tile, row by row.
  template <typename Visit>
  void forEach(Visit visit) const {
    for (unsigned row = 0; row < height_; ++row) {
      for (unsigned column = 0; column < width_; ++column) {
        const Tile* tile = index_[static_cast<std::size_t>(row) * width_ + column].get();
        if (tile == nullptr) continue;
        visit(Cell{(first_x_ + static_cast<int>(column)) * kTileSide,
                   (first_y_ + static_cast<int>(row)) * kTileSide},
              *tile);
      }
    }
  }

 private:
  /// Extends the index so that it covers `cell`. Returns false if the index would exceed the limit.
  bool cover(const Cell& cell) {
    const std::int64_t tx = cell.x >> kTileShift, ty = cell.y >> kTileShift;
    if (width_ == 0) {
      first_x_ = static_cast<int>(tx);
      first_y_ = static_cast<int>(ty);
    }
    std::int64_t x0 = first_x_, x1 = first_x_ + static_cast<std::int64_t>(width_);
    std::int64_t y0 = first_y_, y1 = first_y_ + static_cast<std::int64_t>(height_);
    if (tx >= x0 && tx < x1 && ty >= y0 && ty < y1) return true;
    // Spare tiles on the side that grows, so that the index is not copied at every new tile.
    const std::int64_t spare = 4 + (std::max(x1 - x0, y1 - y0) >> 2);
    if (tx < x0) x0 = tx - spare;
    if (tx >= x1) x1 = tx + spare;
    if (ty < y0) y0 = ty - spare;
    if (ty >= y1) y1 = ty + spare;
    const auto slots = static_cast<std::size_t>(x1 - x0) * static_cast<std::size_t>(y1 - y0);
    // A dense image of the rectangle with one byte per cell must fit too, because maps are
    // published.
    if (slots > budget_->limit() / kTileCells ||
        !budget_->take((slots - index_.size()) * sizeof(std::unique_ptr<Tile>))) {
      return false;
    }
    std::vector<std::unique_ptr<Tile>> index(slots);
    const auto new_width = static_cast<std::size_t>(x1 - x0);
    for (std::size_t row = 0; row < height_; ++row) {
      const std::size_t target = (row + static_cast<std::size_t>(first_y_ - y0)) * new_width +
                                 static_cast<std::size_t>(first_x_ - x0);
      std::move(index_.begin() + static_cast<std::ptrdiff_t>(row * width_),
                index_.begin() + static_cast<std::ptrdiff_t>((row + 1) * width_),
                index.begin() + static_cast<std::ptrdiff_t>(target));
    }
    index_ = std::move(index);
    first_x_ = static_cast<int>(x0);
    first_y_ = static_cast<int>(y0);
    width_ = static_cast<unsigned>(x1 - x0);
    height_ = static_cast<unsigned>(y1 - y0);
    return true;
  }

  SharedBudget budget_;
  std::vector<std::unique_ptr<Tile>> index_;
  int first_x_ = 0;  ///< tile coordinates of the lower left corner of the index
  int first_y_ = 0;
  unsigned width_ = 0;
  unsigned height_ = 0;
  std::size_t tile_count_ = 0;
};

}  // namespace kestrel
