// SPDX-License-Identifier: BSD-3-Clause
#include "known_walls.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surfel_lanes.h"

namespace kestrel {
namespace {

/// A point is on a wall if its nearest surfel is within this distance, cells: the surfels of a wall
/// are one cell apart. Those of a distant wall are as far apart as its hits.
constexpr float kOnWallCells = 1.5F;
/// A beam along a wall (sine of the angle between them) does not cross it.
constexpr float kLeastSine = 0.05F;

/// The end of a beam in the map, and its direction.
struct BeamEnd {
  Eigen::Vector2f place, direction;
};

/// Where the beam passes the wall of the surfel: crosses its line or, without a line, is nearest to
/// it.
Eigen::Vector2f passed(const Surfel& surfel, const BeamEnd& beam) {
  const Eigen::Vector2f offset = beam.place - surfel.on_wall;
  if (isPoint(surfel)) return beam.place - offset.dot(beam.direction) * beam.direction;
  const Eigen::Vector2f normal = normalOf(surfel);
  const float sine = normal.dot(beam.direction);
  if (std::abs(sine) < kLeastSine) return beam.place;
  return beam.place - normal.dot(offset) / sine * beam.direction;
}

/// Whether there is a wall within `reach_m` of where the beam passes the wall of the surfel.
bool passesWall(const SurfelField& surface, const Surfel& nearest, const BeamEnd& beam,
                float reach_m) {
  const Eigen::Vector2f place = passed(nearest, beam);
  const Surfel* wall = surface.nearest(place);
  return wall != nullptr && (place - wall->on_wall).norm() <= reach_m;
}

/// Distance to the nearer one of the two neighboring hits, m.
float spacingAt(const Points& points, std::size_t i) {
  float result = std::numeric_limits<float>::max();
  if (i > 0) result = (points[i] - points[i - 1]).norm();
  if (i + 1 < points.size()) result = std::min(result, (points[i + 1] - points[i]).norm());
  return result;
}

}  // namespace

Points hitsOfKnownWalls(const Submap& map, const Points& points, const Pose2& map_T_base,
                        std::size_t scan_size) {
  const SurfelField& surface = map.surface();
  const float on_wall = kOnWallCells * surface.resolution();
  // Of a thinned scan, the neighbors are farther away than in the scan.
  const float kept = static_cast<float>(points.size()) / static_cast<float>(scan_size);
  const auto isOfWall = [&](const Surfel* nearest, std::size_t i, const BeamEnd& beam) {
    // Hits on a wall are of this wall. The grid is only needed for the others.
    if (nearest != nullptr && (beam.place - nearest->on_wall).norm() <= on_wall) return true;
    if (map.grid().isKnownOrPresumed(map.grid().cellAt(beam.place))) return true;
    const float reach_m = std::max(on_wall, kept * spacingAt(points, i));
    return nearest != nullptr && passesWall(surface, *nearest, beam, reach_m);
  };
  Points result;
  result.reserve(points.size());
  std::size_t first = 0;
  forEachLanes(surface, points, map_T_base, [&](const SurfelLanes& p, std::size_t count) {
    const Lanes has_surfel = p.hasSurfel();
    for (std::size_t k = 0; k < count; ++k) {
      const auto lane = static_cast<Eigen::Index>(k);
      const BeamEnd beam{{p.px[lane], p.py[lane]},
                         Eigen::Vector2f(p.rx[lane], p.ry[lane]).normalized()};
      const Surfel* nearest = has_surfel[lane] > 0.0F ? p.surfels[k] : nullptr;
      if (isOfWall(nearest, first + k, beam)) result.push_back(points[first + k]);
    }
    first += count;
  });
  return result;
}

}  // namespace kestrel
