// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
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

/// The bounds of the single points in a block of poses. They bound the parts of the block, too.
class PointBounds {
 public:
  /// The block from cell (x, y) on.
  void set(const BoundImages& images, const std::vector<RotatedPoint>& points, int x, int y) {
    sum_ = 0;
    bounds_.clear();
    for (const RotatedPoint& p : points) {
      bounds_.push_back(images.valueAt(p.image, x + p.x, y + p.y));
      sum_ += bounds_.back();
    }
    lookups_ += static_cast<std::int64_t>(points.size());
    sort();
  }

  /// The bound of a part of the block, or 0 if it is below `limit`. Most parts are far below or
  /// just below the limit. So what the points lose is subtracted from the bound of the block: few
  /// points decide.
  int within(const BoundImages& images, const std::vector<RotatedPoint>& points, int x, int y,
             int limit) {
    constexpr std::size_t kChunk = 8;
    int sum = sum_;
    for (std::size_t i = 0; i < order_.size() && sum >= limit;) {
      const std::size_t end = std::min(i + kChunk, order_.size());
      lookups_ += static_cast<std::int64_t>(end - i);
      for (; i < end; ++i) {
        const RotatedPoint& p = points[order_[i]];
        sum -= std::max(0, bounds_[order_[i]] - images.valueAt(p.image, x + p.x, y + p.y));
      }
    }
    return sum >= limit ? sum : 0;
  }

  /// Number of look-ups since the last call.
  std::int64_t takeLookups() { return std::exchange(lookups_, 0); }

 private:
  /// The points with much to lose first, and those with nothing to lose not at all.
  void sort() {
    order_.clear();
    for (const auto& [from, to] : {std::pair(33, 64), std::pair(1, 33)}) {
      for (std::uint32_t i = 0; i < bounds_.size(); ++i)
        if (bounds_[i] >= from && bounds_[i] < to) order_.push_back(i);
    }
  }

  std::vector<int> bounds_;
  std::vector<std::uint32_t> order_;
  int sum_ = 0;
  std::int64_t lookups_ = 0;
};

}  // namespace kestrel
