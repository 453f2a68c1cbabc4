// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/map/submap.h"
#include "loop_world.h"
#include "room.h"

namespace kestrel::rooms {

using room::Segment;

/// Walls that lie `x` m farther.
inline std::vector<Segment> moved(const std::vector<Segment>& walls, double x) {
  std::vector<Segment> result;
  for (const Segment& s : walls) result.push_back({s.x0 + x, s.y0, s.x1 + x, s.y1});
  return result;
}

/// A room that has no place in common with room::walls().
inline std::vector<Segment> otherRoom() {
  std::vector<Segment> walls;
  loop_world::addBox(walls, -6, -1.5, 12, 3);
  loop_world::addBox(walls, -1.2, -0.5, 0.5, 0.5);
  loop_world::addBox(walls, 3.1, 0.4, 0.9, 0.3);
  return walls;
}

/// Three scans from a room that is `x` m away.
inline void insertAt(double x, const std::vector<Segment>& walls, Submap& map) {
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)})
    map.insert(room::scanFrom(Pose2(x, 0, 0) * pose, walls), Pose2(x, 0, 0) * pose);
}

}  // namespace kestrel::rooms
