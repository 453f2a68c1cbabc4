// SPDX-License-Identifier: BSD-3-Clause
#include "spread_points.h"

#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "kestrel_slam/matching/thinned.h"

namespace kestrel {
namespace {

/// Number of points. Those in the same square of this side are one: a wall that is near has more
/// beams than one that is far away, but it does not say more.
constexpr std::size_t kPoints = 160;
constexpr double kSquareM = 0.1;
constexpr float kFarthestM = 60.0F;

}  // namespace

Points spreadPoints(const Points& points, std::size_t multiple) {
  std::unordered_set<std::int64_t> taken;
  Points result;
  for (const Eigen::Vector2f& p : points) {
    if (!(p.norm() <= kFarthestM)) continue;  // also if it is not finite
    const auto square = [](float x) {
      return static_cast<std::int64_t>(std::floor(static_cast<double>(x) / kSquareM));
    };
    if (taken.insert(square(p.x()) * (1LL << 32) + square(p.y())).second) result.push_back(p);
  }
  result = sampled(result, kPoints);
  result.resize(result.size() - result.size() % multiple);
  return result;
}

}  // namespace kestrel
