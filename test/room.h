// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel::room {

/// A wall from (x0, y0) to (x1, y1), m.
struct Segment {
  double x0, y0, x1, y1;
};

/// A room of 8 m × 6 m around the origin. The box in one corner makes every view unique.
inline std::vector<Segment> walls() {
  return {{-4, -3, 4, -3}, {4, -3, 4, 3}, {4, 3, -4, 3}, {-4, 3, -4, -3},  {2, 1, 3, 1},
          {3, 1, 3, 2},    {3, 2, 2, 2},  {2, 2, 2, 1},  {-4, 0, -2.5, 0}, {-1, -3, -1, -2}};
}

/// An infinitely long corridor along x.
inline std::vector<Segment> corridor() { return {{-500, -1, 500, -1}, {-500, 1, 500, 1}}; }

/// Distance to the nearest wall in a direction; infinite if there is no wall.
inline double cast(const std::vector<Segment>& segments, const Pose2& from, double angle) {
  const double dx = std::cos(from.yaw + angle), dy = std::sin(from.yaw + angle);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Segment& s : segments) {
    const double ex = s.x1 - s.x0, ey = s.y1 - s.y0;
    const double det = ex * dy - ey * dx;
    if (std::abs(det) < 1e-12) continue;
    const double range = (ex * (s.y0 - from.y) - ey * (s.x0 - from.x)) / det;
    const double along = (dx * (s.y0 - from.y) - dy * (s.x0 - from.x)) / det;
    if (range > 0.0 && along >= 0.0 && along <= 1.0) nearest = std::min(nearest, range);
  }
  return nearest;
}

/// Noise-free scan of a 360° laser at `pose`. Beams longer than `max_range_m` only mark free space.
inline PlanarScan scanFrom(const Pose2& pose, const std::vector<Segment>& segments = walls(),
                           int beams = 360, double max_range_m = 12.0) {
  PlanarScan scan;
  for (int i = 0; i < beams; ++i) {
    const double angle = 2.0 * kPi * i / beams;
    const double range = cast(segments, pose, angle);
    const bool hit = range < max_range_m;
    const double reach = hit ? range : max_range_m;
    scan.rays.push_back({Eigen::Vector2f::Zero(),
                         Eigen::Vector2f(static_cast<float>(reach * std::cos(angle)),
                                         static_cast<float>(reach * std::sin(angle))),
                         hit});
  }
  return scan;
}

/// A map of the room made from three scans.
inline Submap map(const Pose2& map_T_room = Pose2()) {
  Submap map{OccupancyGridConfig()};
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)}) {
    map.insert(scanFrom(pose), map_T_room * pose);
  }
  return map;
}

}  // namespace kestrel::room
