// SPDX-License-Identifier: BSD-3-Clause
#include "wall_tangent.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Neighboring hits of a scan that make a direction: at least this far apart together, each at
/// most this far, bent by at most this sine.
constexpr std::size_t kMaxTangentBeams = 8;
constexpr float kMinTangentLength = 0.15F;
constexpr float kMaxTangentGap = 1.0F;
constexpr float kMaxTangentBend = 0.2F;
/// Far along a wall neighbors are farther apart, up to this; they have to stand on one line within
/// this, with no gap much wider than the other.
constexpr float kMaxSparseGap = 8.0F;
constexpr float kMaxSparseOffset = 0.08F;
constexpr float kMaxSparseRatio = 3.0F;

/// (cos, sin) of twice the angle of a vector.
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
    if (b + a < kMinTangentLength) continue;  // noise is as large as the distance: look farther
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
