// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// Every k-th point, so that about `count` remain.
inline Points thinned(const Points& points, std::size_t count) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / count);
  Points result;
  result.reserve(points.size() / step + 1);
  for (std::size_t i = 0; i < points.size(); i += step) result.push_back(points[i]);
  return result;
}

/// At most `count` points, evenly distributed.
inline Points sampled(const Points& points, std::size_t count) {
  if (points.size() <= count) return points;
  Points result;
  result.reserve(count);
  for (std::size_t i = 0; i < count; ++i) result.push_back(points[i * points.size() / count]);
  return result;
}

}  // namespace kestrel
