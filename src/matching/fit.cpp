// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/fit.h"

#include <algorithm>

#include "kestrel_slam/geometry/symmetric_axes.h"
#include "surfel_lanes.h"

namespace kestrel {

double leastConstraint(const Fit& fit) {
  // The part of kAlongWeight (SurfelField) is not a constraint.
  constexpr double kAlong = kAlongWeight / (1.0 + kAlongWeight);
  return symmetricAxes(fit.normals).eigenvalues(0) - kAlong;
}

Fit fitOf(const Submap& map, const Points& points, const Pose2& map_T_base, double scale_m) {
  const auto inverse_scale2 = static_cast<float>(1.0 / (scale_m * scale_m));
  constexpr float kOnWall = 0.5F;  // within `scale_m` of a wall
  Lanes sum = Lanes::Zero(), squares = Lanes::Zero();
  Lanes n11 = Lanes::Zero(), n12 = Lanes::Zero(), n22 = Lanes::Zero();
  std::size_t off_walls = 0, unknown = 0;
  forEachLanes(map.surface(), points, map_T_base, [&](const SurfelLanes& p, std::size_t count) {
    const Lanes distance2 = p.distance2();
    Lanes fit = p.hasSurfel() / (1.0F + distance2 * inverse_scale2);
    Lanes on_wall = Lanes::Ones(), c11 = p.a11, c12 = p.a12, c22 = p.a22;
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (fit[i] > kOnWall) {
        if (!isPoint(*p.surfels[k])) continue;
        const Eigen::Vector3f constraint = constraintOf(*p.surfels[k]);
        c11[i] = constraint.x(), c12[i] = constraint.y(), c22[i] = constraint.z();
        continue;
      }
      // Points on walls are in known space. The grid is only needed for the others.
      on_wall[i] = 0.0F;
      ++off_walls;
      if (map.grid().isKnownOrPresumed(map.grid().cellAt({p.px[i], p.py[i]}))) continue;
      fit[i] = 0.0F;
      ++unknown;
    }
    sum += fit;
    squares += on_wall * fit * distance2;
    n11 += on_wall * c11, n12 += on_wall * c12, n22 += on_wall * c22;
  });
  Fit result;
  if (unknown == points.size()) return result;
  const auto known = static_cast<double>(points.size() - unknown);
  result.score = static_cast<double>(sum.sum()) / known;
  result.known = known / static_cast<double>(points.size());
  result.on_wall =
      static_cast<double>(points.size() - off_walls) / static_cast<double>(points.size());
  result.residual_variance = static_cast<double>(squares.sum() / std::max(sum.sum(), 1.0F));
  result.normals << n11.sum(), n12.sum(), n12.sum(), n22.sum();
  result.normals /= std::max(result.normals.trace(), 1.0);
  return result;
}

}  // namespace kestrel
