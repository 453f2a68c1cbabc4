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

  explicit CellMap(std::size_t limit_bytes) : limit_(limit_bytes), tiles_(limit_bytes) {}

  const Value* find(const GridIndex<2>& index) const {
    const Cell cell{index.x(), index.y()};
    const Tile* tile = tiles_.find(cell);
    return tile != nullptr ? &(*tile)[offsetInTile(cell)] : nullptr;
  }
  Value* find(const GridIndex<2>& index) {
    return const_cast<Value*>(std::as_const(*this).find(index));
  }
  /// nullptr if the memory limit is reached.
  Value* obtain(const GridIndex<2>& index) {
    Tile* tile = obtainTile(index);
    return tile != nullptr ? &(*tile)[offsetInTile({index.x(), index.y()})] : nullptr;
  }
  /// The tile of a cell; nullptr if the memory limit is reached.
  Tile* obtainTile(const GridIndex<2>& index) {
    const Cell cell{index.x(), index.y()};
    const Cell number{cell.x >> kTileShift, cell.y >> kTileShift};
    if (last_ == nullptr || number.x != last_number_.x || number.y != last_number_.y) {
      last_ = tiles_.obtain(cell);
      last_number_ = number;
    }
    return last_;
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
  std::size_t limit_;
  TileMap<Tile> tiles_;
  Cell last_number_{0, 0};  ///< of the tile that was written last
  Tile* last_ = nullptr;
};

template <typename Value>
class CellMap<3, Value> {
 public:
  explicit CellMap(std::size_t limit_bytes) : limit_(limit_bytes) {}

  const Value* find(const GridIndex<3>& index) const {
    const auto block = blocks_.find(keyOf(index));
    return block != blocks_.end() ? &(*block->second)[offsetOf(index)] : nullptr;
  }
  Value* find(const GridIndex<3>& index) {
    return const_cast<Value*>(std::as_const(*this).find(index));
  }
  Value* obtain(const GridIndex<3>& index) {
    const std::uint64_t key = keyOf(index);
    if (key != last_key_ || last_ == nullptr) {
      if (!lookUp(key)) return nullptr;
    }
    return &(*last_)[offsetOf(index)];
  }

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
  static constexpr int kShift = 3, kSide = 1 << kShift, kBits = 21;
  using Block = std::array<Value, kSide * kSide * kSide>;

  static std::uint64_t keyOf(const GridIndex<3>& index) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1U;
    std::uint64_t key = 0;
    for (int i = 0; i < 3; ++i) {
      key = key << kBits | (static_cast<std::uint64_t>(index(i) >> kShift) & kMask);
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
  static std::size_t offsetOf(const GridIndex<3>& index) {
    constexpr unsigned kMask = kSide - 1U;
    const auto part = [&](int i) {
      return static_cast<std::size_t>(static_cast<unsigned>(index(i)) & kMask);
    };
    return (part(2) << (2 * kShift)) | (part(1) << kShift) | part(0);
  }

  bool lookUp(std::uint64_t key) {
    auto block = blocks_.find(key);
    if (block == blocks_.end()) {
      if (memoryBytes() + sizeof(Block) > limit_) return false;
      block = blocks_.emplace(key, std::make_unique<Block>()).first;
    }
    last_key_ = key;
    last_ = block->second.get();
    return true;
  }

  std::size_t limit_;
  std::unordered_map<std::uint64_t, std::unique_ptr<Block>> blocks_;
  std::uint64_t last_key_ = 0;  ///< of the block that was written last
  Block* last_ = nullptr;
};

}  // namespace kestrel
