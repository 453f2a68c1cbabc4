// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"

namespace kestrel {

/// Four floats that the compiler keeps in one register on x86-64 and on ARM, without machine flags.
using Lanes = Eigen::Array<float, 4, 1>;
constexpr std::size_t kLanes = 4;

/// Four points of a scan, each with the surfel nearest to it: what sums over a scan are made of.
/// A point far from any wall, or past the end of the scan, has a surfel of zeros.
struct SurfelLanes {
  Lanes rx, ry;         ///< the points, turned into map but not shifted, m (paper 001 eq. 8)
  Lanes px, py;         ///< the points in map, m
  Lanes ex, ey;         ///< from the surfel's mean to the point, m
  Lanes a11, a12, a22;  ///< of the surfel
  std::array<const Surfel*, kLanes> surfels;

  Lanes distance2() const { return ex * (a11 * ex + a12 * ey) + ey * (a12 * ex + a22 * ey); }

  /// 1 where there is a surfel (whose trace is never below 1), 0 elsewhere.
  Lanes hasSurfel() const { return (a11 + a22).min(1.0F); }
};

/// Calls `visit(lanes, count)` for every four points of a scan seen from `map_T_base`; the last
/// time only the first `count` lanes are points.
template <typename Points, typename Visit>
inline void forEachLanes(const SurfelField& surface, const Points& points, const Pose2& map_T_base,
                         Visit visit) {
  static const Surfel kNothing{Eigen::Vector2f::Zero(), 0.0F, 0.0F, 0.0F, {}};
  const auto c = static_cast<float>(std::cos(map_T_base.yaw));
  const auto s = static_cast<float>(std::sin(map_T_base.yaw));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  SurfelLanes lanes;
  Lanes sx = Lanes::Zero(), sy = Lanes::Zero(), mx, my;  // scan points, means
  const auto gather = [&](std::size_t first, auto count) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(count); ++i) {
      const Eigen::Vector2f& p = points[first + static_cast<std::size_t>(i)];
      sx[i] = p.x();
      sy[i] = p.y();
    }
    lanes.rx = c * sx - s * sy;
    lanes.ry = s * sx + c * sy;
    lanes.px = x + lanes.rx;
    lanes.py = y + lanes.ry;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kLanes); ++i) {
      const bool is_point = i < static_cast<Eigen::Index>(count);
      const Surfel* surfel = is_point ? surface.nearest({lanes.px[i], lanes.py[i]}) : nullptr;
      if (surfel == nullptr) surfel = &kNothing;
      lanes.surfels[static_cast<std::size_t>(i)] = surfel;
      mx[i] = surfel->mean.x();
      my[i] = surfel->mean.y();
      lanes.a11[i] = surfel->a11;
      lanes.a12[i] = surfel->a12;
      lanes.a22[i] = surfel->a22;
    }
    lanes.ex = lanes.px - mx;
    lanes.ey = lanes.py - my;
  };
  for (std::size_t first = 0; first < points.size(); first += kLanes) {
    const std::size_t count = std::min(kLanes, points.size() - first);
    if (count == kLanes) {
      gather(first, std::integral_constant<std::size_t, kLanes>());
    } else {
      gather(first, count);
    }
    visit(lanes, count);
  }
}

}  // namespace kestrel
