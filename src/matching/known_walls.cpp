// SPDX-License-Identifier: BSD-3-Clause
#include "known_walls.h"

#include <cmath>

#include "surfel_lanes.h"

namespace kestrel {
namespace {

/// A point is on a wall if its nearest surfel is within this distance, cells. The surfels of a wall
/// are one cell apart.
constexpr float kOnWallCells = 1.5F;
/// A beam along a wall (sine of the angle between them) does not cross it.
constexpr float kLeastSine = 0.05F;

/// Where the beam to `end` with the direction `beam` passes the wall of the surfel: crosses its
/// line or, without a line, is nearest to it.
Eigen::Vector2f passed(const Surfel& surfel, const Eigen::Vector2f& end,
                       const Eigen::Vector2f& beam) {
  const Eigen::Vector2f offset = end - surfel.on_wall;
  if (isPoint(surfel)) return end - offset.dot(beam) * beam;
  const Eigen::Vector2f normal = normalOf(surfel);
  const float sine = normal.dot(beam);
  return std::abs(sine) < kLeastSine ? end
                                     : Eigen::Vector2f(end - normal.dot(offset) / sine * beam);
}

/// Whether there is a wall where the beam passes the wall that is nearest to its end.
bool passesWall(const SurfelField& surface, const Surfel& nearest, const Eigen::Vector2f& end,
                const Eigen::Vector2f& beam) {
  const Eigen::Vector2f place = passed(nearest, end, beam);
  const Surfel* wall = surface.nearest(place);
  return wall != nullptr && (place - wall->on_wall).norm() <= kOnWallCells * surface.resolution();
}

}  // namespace

Points hitsOfKnownWalls(const Submap& map, const Points& points, const Pose2& map_T_base) {
  const SurfelField& surface = map.surface();
  const float on_wall = kOnWallCells * surface.resolution();
  Points result;
  result.reserve(points.size());
  std::size_t first = 0;
  forEachLanes(surface, points, map_T_base, [&](const SurfelLanes& p, std::size_t count) {
    const Lanes has_surfel = p.hasSurfel(), offset2 = p.ex * p.ex + p.ey * p.ey;
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const Eigen::Vector2f end(p.px[i], p.py[i]), arm(p.rx[i], p.ry[i]);
      const bool has = has_surfel[i] > 0.0F;
      // Hits on a wall are of this wall. The grid is only needed for the others.
      if ((has && offset2[i] <= on_wall * on_wall) ||
          map.grid().isKnownOrPresumed(map.grid().cellAt(end)) ||
          (has && passesWall(surface, *p.surfels[k], end, arm.normalized())))
        result.push_back(points[first + k]);
    }
    first += count;
  });
  return result;
}

}  // namespace kestrel
