// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "bound_images.h"

namespace kestrel {

/// Where a point may be if the yaw is in an interval: a square of cells relative to the pose.
struct RotatedPoint {
  std::int32_t x, y, image;  ///< its lower left cell, and the image for its side
};

/// All points of a scan at a yaw interval, and where their values are in the images.
class RotatedPoints {
 public:
  RotatedPoints() = default;
  RotatedPoints(const BoundImages& images, std::vector<RotatedPoint> points);

  bool empty() const { return points_.empty(); }
  const std::vector<RotatedPoint>& points() const { return points_; }
  /// BoundImages::placeFor() each point, if the pose has this x % 4.
  const std::int32_t* places(int phase) const {
    return places_.data() + static_cast<std::size_t>(phase) * points_.size();
  }
  /// Whether the values of all points are in the images.
  bool areIn(const BoundImages& images, int x, int y) const {
    return images.containsStrip(low_, high_, x, y);
  }
  std::size_t memoryBytes() const;

 private:
  std::vector<RotatedPoint> points_;
  std::vector<std::int32_t> places_;  ///< of all points, for each phase
  Cell low_{}, high_{};               ///< of the points
};

/// The bounds of the single points in a strip: blocks of poses in a row, 4 cells apart, with the
/// same yaw interval. They bound the parts of the blocks, too. In the images the blocks of a strip
/// are neighbors in memory, so that all of them cost about as much as one.
class StripBounds {
 public:
  static constexpr int kLanes = BoundImages::kTileBlocks;
  /// The bounds of so many points are added in a byte.
  static constexpr std::size_t kTogether = 4;
  static_assert(kTogether * BoundImages::kMax <= 0xFF, "the sum fits into a byte");
  static constexpr std::size_t kMostPoints = 500;
  static_assert(kMostPoints * BoundImages::kMax < 0x7FFF, "the sum of all points fits");

  /// The blocks at the cells (x, y), (x + 4, y), …; bit n of `lanes` is set if block n counts.
  /// The number of points is a multiple of kTogether and at most kMostPoints.
  void set(const BoundImages& images, const RotatedPoints& points, int x, int y, unsigned lanes);

  /// Bounds the parts of the blocks at (x, y), (x + 4, y), …. Returns the lanes whose bounds reach
  /// `limit`, see sums(). Most parts are far below or just below the limit. So what the points lose
  /// is subtracted from the bounds of the blocks: few points decide.
  unsigned within(const BoundImages& images, const RotatedPoints& points, int x, int y, int limit);

  /// The bounds of the last call of `within`, of the lanes that it returned.
  const std::array<std::int16_t, kLanes>& sums() const { return sums_; }

  /// Number of rows of lanes that were looked up since the last call.
  std::int64_t takeLookups() { return std::exchange(lookups_, 0); }

 private:
  /// One value for each lane. The compiler adds and compares 16 bytes in one instruction.
  using Row = std::uint8_t __attribute__((vector_size(kLanes)));
  using Words = std::uint16_t __attribute__((vector_size(kLanes)));
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
                "the first of two bytes is the lower one");
  /// A sum for each lane; -1 for a lane that does not count. Even and odd lanes are apart.
  struct Sums {
    Words even{}, odd{};
    void add(const Row& row);
    void subtract(const Row& row);
    void ignore(std::size_t lane);
    bool reach(int limit) const;
  };
  static Row rowOf(const std::uint8_t* values);
  template <typename RowAt>
  unsigned subtract(const RowAt& row, int limit);
  static std::array<std::int16_t, kLanes> values(const Sums& sums);
  void sort(std::size_t lane);

  std::vector<const std::uint8_t*> rows_;  ///< the bounds of the points in the blocks
  std::vector<std::uint32_t> order_;       ///< of the points
  std::vector<Row> groups_;                ///< the sums of the bounds of kTogether points in order
  Sums whole_;                             ///< of the blocks
  std::array<std::int16_t, kLanes> sums_{};
  std::int64_t lookups_ = 0;
};

}  // namespace kestrel
