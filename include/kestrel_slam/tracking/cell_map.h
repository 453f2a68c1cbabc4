// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

#include "kestrel_slam/map/tile_map.h"

namespace kestrel {

/// Index of a cell in a grid of D dimensions.
template <int D>
using GridIndex = Eigen::Matrix<int, D, 1>;

/// Cells that are allocated in blocks when they are written: a TileMap in the plane, hashed voxel
/// blocks in space.
template <int D, typename Value>
class CellMap;

template <typename Value>
class CellMap<2, Value> {
 public:
  using Tile = std::array<Value, kTileCells>;
  static constexpr int kBlockShift = kTileShift;

  explicit CellMap(std::size_t limit_bytes) : limit_(limit_bytes), tiles_(limit_bytes) {}

  const Value* find(const GridIndex<2>& index) const {
    const Tile* tile = findBlock(index);
    return tile != nullptr ? &(*tile)[offsetOf(index)] : nullptr;
  }
  /// The block of a cell, and the offset of the cell in it.
  const Tile* findBlock(const GridIndex<2>& index) const {
    return tiles_.find(Cell{index.x(), index.y()});
  }
  Tile* findBlock(const GridIndex<2>& index) {
    return const_cast<Tile*>(std::as_const(*this).findBlock(index));
  }
  static std::size_t offsetOf(const GridIndex<2>& index) {
    return offsetInTile({index.x(), index.y()});
  }
  /// The same; cells in the tile of the last one need no search.
  Value* find(const GridIndex<2>& index) {
    return isInLast(index) || enter(tiles_.find(Cell{index.x(), index.y()}), index)
               ? &(*last_)[offsetOf(index)]
               : nullptr;
  }
  /// nullptr if the memory limit is reached.
  Value* obtain(const GridIndex<2>& index) {
    Tile* tile = obtainTile(index);
    return tile != nullptr ? &(*tile)[offsetOf(index)] : nullptr;
  }
  /// The tile of a cell; nullptr if the memory limit is reached.
  Tile* obtainTile(const GridIndex<2>& index) {
    return isInLast(index) || enter(tiles_.obtain(Cell{index.x(), index.y()}), index) ? last_
                                                                                      : nullptr;
  }

  /// Removes the blocks that have no cell within `radius` cells of `center` in any direction.
  void keepAround(const GridIndex<2>& center, int radius) {
    TileMap<Tile> kept(limit_);
    tiles_.forEach([&](const Cell& corner, const Tile& tile) {
      const GridIndex<2> low = GridIndex<2>(corner.x, corner.y) - center;
      const bool near = (low.array() <= radius).all() && (low.array() + kTileSide > -radius).all();
      if (!near) return;
      if (Tile* copy = kept.obtain(corner)) *copy = tile;
    });
    tiles_ = std::move(kept);
    last_ = nullptr;
  }
  std::size_t memoryBytes() const { return tiles_.memoryBytes(); }

 private:
  bool isInLast(const GridIndex<2>& index) const {
    return last_ != nullptr && (index.x() >> kTileShift) == last_number_.x &&
           (index.y() >> kTileShift) == last_number_.y;
  }
  /// Remembers the tile; false if there is none.
  bool enter(Tile* tile, const GridIndex<2>& index) {
    last_ = tile;
    last_number_ = {index.x() >> kTileShift, index.y() >> kTileShift};
    return tile != nullptr;
  }

  std::size_t limit_;
  TileMap<Tile> tiles_;
  Cell last_number_{0, 0};  ///< of the tile that was used last
  Tile* last_ = nullptr;
};

template <typename Value>
class CellMap<3, Value> {
 public:
  static constexpr int kBlockShift = 3;
  static constexpr int kSide = 1 << kBlockShift;
  using Block = std::array<Value, kSide * kSide * kSide>;

  explicit CellMap(std::size_t limit_bytes) : limit_(limit_bytes) {}

  const Value* find(const GridIndex<3>& index) const {
    const Block* block = findBlock(index);
    return block != nullptr ? &(*block)[offsetOf(index)] : nullptr;
  }
  const Block* findBlock(const GridIndex<3>& index) const {
    const auto block = blocks_.find(keyOf(index));
    return block != blocks_.end() ? block->second.get() : nullptr;
  }
  static std::size_t offsetOf(const GridIndex<3>& index) {
    constexpr unsigned kMask = kSide - 1U;
    const auto part = [&](int i) {
      return static_cast<std::size_t>(static_cast<unsigned>(index(i)) & kMask);
    };
    return (part(2) << (2 * kBlockShift)) | (part(1) << kBlockShift) | part(0);
  }
  Value* find(const GridIndex<3>& index) { return look(index, false); }
  Value* obtain(const GridIndex<3>& index) { return look(index, true); }

  void keepAround(const GridIndex<3>& center, int radius) {
    for (auto block = blocks_.begin(); block != blocks_.end();) {
      const GridIndex<3> low = cornerOf(block->first) - center;
      const bool near = (low.array() <= radius).all() && (low.array() + kSide > -radius).all();
      block = near ? std::next(block) : blocks_.erase(block);
    }
    last_ = nullptr;
  }
  std::size_t memoryBytes() const { return blocks_.size() * sizeof(Block); }

 private:
  static constexpr int kBits = 21;

  static std::uint64_t keyOf(const GridIndex<3>& index) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1U;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i) {
      key = key << kBits | (static_cast<std::uint64_t>(index(i) >> kBlockShift) & kMask);
    }
    return key;
  }
  static GridIndex<3> cornerOf(std::uint64_t key) {
    GridIndex<3> corner;
    for (int i = 2; i >= 0; --i, key >>= kBits) {
      const auto shifted = static_cast<std::int64_t>(key << (64 - kBits));
      corner(i) = static_cast<int>(shifted >> (64 - kBits)) * kSide;
    }
    return corner;
  }

  Value* look(const GridIndex<3>& index, bool create) {
    const std::uint64_t key = keyOf(index);
    if ((key != last_key_ || last_ == nullptr) && !enter(key, create)) return nullptr;
    return &(*last_)[offsetOf(index)];
  }
  bool enter(std::uint64_t key, bool create) {
    auto block = blocks_.find(key);
    if (block == blocks_.end()) {
      if (!create || memoryBytes() + sizeof(Block) > limit_) return false;
      block = blocks_.emplace(key, std::make_unique<Block>()).first;
    }
    last_key_ = key;
    last_ = block->second.get();
    return true;
  }

  std::size_t limit_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Block>> blocks_;
  std::uint64_t last_key_ = 0;  ///< of the block that was used last
  Block* last_ = nullptr;
};

}  // namespace kestrel
