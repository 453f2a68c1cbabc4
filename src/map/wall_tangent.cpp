// SPDX-License-Identifier: BSD-3-Clause
#include "wall_tangent.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Conditions for a wall direction from neighboring hits of a scan: minimum total distance, maximum
/// distance of one neighbor (m), and maximum sine of the bend.
constexpr std::size_t kMaxTangentBeams = 8;
constexpr float kMinTangentLength = 0.15F;
constexpr float kMaxTangentGap = 1.0F;
constexpr float kMaxTangentBend = 0.2F;
/// Conditions for distant neighbors, far along a wall: maximum distance of one neighbor, maximum
/// offset from the line (m), and maximum ratio of the two distances.
constexpr float kMaxSparseGap = 8.0F;
constexpr float kMaxSparseOffset = 0.08F;
constexpr float kMaxSparseRatio = 3.0F;

/// (cos, sin) of twice the angle of a vector: equal for opposite directions.
Eigen::Vector2f twiceAngle(const Eigen::Vector2f& direction) {
  const Eigen::Vector2f t = direction.normalized();
  return {t.x() * t.x() - t.y() * t.y(), 2.0F * t.x() * t.y()};
}

}  // namespace

Eigen::Vector2f tangentAt(const std::vector<OccupancyGrid::Changes::Hit>& hits, std::size_t i,
                          bool& sparse) {
  sparse = false;
  for (std::size_t k = 1; k <= kMaxTangentBeams; k *= 2) {
    if (i < k || i + k >= hits.size()) break;
    const Eigen::Vector2f before = hits[i].point - hits[i - k].point;
    const Eigen::Vector2f after = hits[i + k].point - hits[i].point;
    const float b = before.norm(), a = after.norm();
    if (b + a < kMinTangentLength)
      continue;  // the noise is as large as the distance: use farther neighbors
    const float sine = (before.x() * after.y() - before.y() * after.x());
    if (std::abs(sine) > kMaxTangentBend * a * b || before.dot(after) <= 0.0F) break;
    const float wide = std::max(a, b);
    sparse = wide > kMaxTangentGap;
    if (sparse && (wide > kMaxSparseGap || wide > kMaxSparseRatio * std::min(a, b) ||
                   std::abs(sine) > kMaxSparseOffset * (a + b))) {
      break;
    }
    return twiceAngle(before + after);
  }
  return Eigen::Vector2f::Zero();
}

}  // namespace kestrel
