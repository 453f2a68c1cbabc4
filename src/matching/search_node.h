// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <tuple>

namespace kestrel {

/// A strip of blocks of poses: 4 >> level cells from (x, y), (x + 4, y), … on, and the yaw interval
/// k of its level. On the last level, a single pose.
struct SearchNode {
  std::int32_t sum;  ///< of the bounds of all points, of the best block
  std::int32_t k, x, y;
  std::uint16_t level, lanes;  ///< bit n of `lanes`: block n is of interest
};

inline bool isWorse(const SearchNode& a, const SearchNode& b) {
  if (a.sum != b.sum) return a.sum < b.sum;
  return std::tie(a.level, b.k, b.y, b.x) < std::tie(b.level, a.k, a.y, a.x);
}

/// The order by place, from back to front; single poses are in front.
inline bool isAfter(const SearchNode& a, const SearchNode& b) {
  return std::tie(a.level, b.k, b.y, b.x) < std::tie(b.level, a.k, a.y, a.x);
}

}  // namespace kestrel
