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

/// Four floats in one vector register on x86-64 and ARM, without special compiler flags.
using Lanes = Eigen::Array<float, 4, 1>;
constexpr std::size_t kLanes = 4;

/// Four points of a scan with their nearest surfels, for sums over a scan. A point without a surfel
/// within reach, and lanes past the end of the scan, have a surfel of zeros.
struct SurfelLanes {
  Lanes rx,
      ry;  ///< the points rotated to the map frame, but not translated, m [Kohlbrecher 2011, eq. 8]
  Lanes px, py;         ///< the points in the map frame, m
  Lanes ex, ey;         ///< from the wall of the surfel to the point, m
  Lanes a11, a12, a22;  ///< information matrices of the surfels
  std::array<const Surfel*, kLanes> surfels;

  Lanes distance2() const { return ex * (a11 * ex + a12 * ey) + ey * (a12 * ex + a22 * ey); }

  /// 1 if there is a surfel (its trace is at least 1), else 0.
  Lanes hasSurfel() const { return (a11 + a22).min(1.0F); }
};

/// Calls `visit(lanes, count)` for every four points of a scan at `map_T_base`. In the last call
/// only the first `count` lanes are points.
template <typename Points, typename Visit>
inline void forEachLanes(const SurfelField& surface, const Points& points, const Pose2& map_T_base,
                         Visit visit) {
  static const Surfel kNoSurfel{
      Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), 0.0F, 0.0F, 0.0F, {}};
  const auto c = static_cast<float>(std::cos(map_T_base.yaw));
  const auto s = static_cast<float>(std::sin(map_T_base.yaw));
  const auto x = static_cast<float>(map_T_base.x), y = static_cast<float>(map_T_base.y);
  SurfelLanes lanes;
  Lanes sx = Lanes::Zero(), sy = Lanes::Zero(), mx, my;  // scan points, walls
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
      if (surfel == nullptr) surfel = &kNoSurfel;
      lanes.surfels[static_cast<std::size_t>(i)] = surfel;
      mx[i] = surfel->on_wall.x();
      my[i] = surfel->on_wall.y();
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
