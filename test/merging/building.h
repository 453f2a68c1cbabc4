// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "../graph/loop_world.h"
#include "kestrel_slam/merging/vehicle_map.h"

namespace kestrel::building {

using Walls = std::vector<room::Segment>;

/// Which of the twin buildings.
struct Variant {
  bool other_room = false;   ///< one room is smaller and furnished otherwise
  bool mirrored = false;     ///< seen by a laser that is mounted upside down
  bool other_place = false;  ///< another building
  double deeper_m = 0.0;     ///< how much deeper one room is
  double partition_x = 0.0;  ///< where a wall divides one room; 0: there is none
  double furniture_m = 0.0;  ///< how far the furniture of one room was moved
  bool low_cabinet = false;  ///< a cabinet of 1.6 m, which a vehicle that flies higher does not see
};

/// A corridor from x = 0 to 24 m with three rooms on either side. The doors are at their middles.
inline Walls walls(const Variant& variant = {}) {
  using loop_world::addBox;
  Walls all = {{0, -1.2, 0, 1.2}, {24, -1.2, 24, 1.2}};
  const double depth[] = {5.0, 4.0, 6.0}, below[] = {4.5, 5.5, 3.5};
  const double shift = variant.other_place ? 1.3 : 0.0;
  for (int i = 0; i < 3; ++i) {
    const double x = 8.0 * i;
    const bool other = variant.other_room && i == 1;
    const double deeper = i == 1 ? variant.deeper_m : 0.0;
    const double d = depth[i] + shift + deeper - (other ? 1.2 : 0.0), b = -below[i] - 0.7 * shift;
    const double left = x + (other ? 1.4 : 0.0);
    // Above: front with a door of 1 m, back and side walls.
    all.insert(all.end(), {{x, 1.2, x + 3.5, 1.2},
                           {x + 4.5, 1.2, x + 8, 1.2},
                           {left, 1.2, left, 1.2 + d},
                           {x + 8, 1.2, x + 8, 1.2 + d},
                           {left, 1.2 + d, x + 8, 1.2 + d}});
    all.insert(all.end(), {{x, -1.2, x + 3.5, -1.2},
                           {x + 4.5, -1.2, x + 8, -1.2},
                           {x, -1.2, x, -1.2 + b},
                           {x + 8, -1.2, x + 8, -1.2 + b},
                           {x, -1.2 + b, x + 8, -1.2 + b}});
    addBox(all, x + 6.0 - 0.5 * i - (other ? 2.9 : 0.0) - (i == 1 ? variant.furniture_m : 0.0),
           2.2 + 0.6 * i, 0.8, 0.6 + 0.3 * i);
    addBox(all, x + 1.0 + 0.7 * i + shift, b + 0.2, 1.2 - 0.3 * i, 0.7);
  }
  if (variant.low_cabinet) addBox(all, 8.8, 4.65, 1.6, 0.55);
  if (variant.partition_x > 0.0) addBox(all, variant.partition_x, 2.0, 0.1, 3.2);
  addBox(all, 10.3 + shift, 1.0, 0.5, 0.2);
  addBox(all, 1.6, -1.2, 0.4, 0.3);
  addBox(all, 19.1 - shift, 0.95, 0.7, 0.25);
  addBox(all, 14.2, -1.2, 0.3, 0.4 + 0.3 * shift);
  if (!variant.mirrored) return all;
  for (room::Segment& wall : all) wall = {wall.x0, -wall.y0, wall.x1, -wall.y1};
  return all;
}

/// Poses along straight lines: every 0.25 m, and every 15 degrees in the corners.
inline std::vector<Pose2> along(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Pose2> poses;
  double yaw = 0.0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d line = corners[i] - corners[i - 1];
    const double next = std::atan2(line.y(), line.x());
    const double turn = i == 1 ? 0.0 : normalizeAngle(next - yaw);
    const int steps = static_cast<int>(std::abs(turn) / 0.26);
    for (int k = 1; k < steps; ++k)
      poses.emplace_back(corners[i - 1].x(), corners[i - 1].y(), yaw + turn * k / steps);
    yaw = next;
    for (double at = 0.0; at < line.norm(); at += 0.25) {
      const Eigen::Vector2d p = corners[i - 1] + line.normalized() * at;
      poses.emplace_back(p.x(), p.y(), yaw);
    }
  }
  return poses;
}

/// Through the rooms from `first` to `last` (0 to 2), above and below.
inline std::vector<Pose2> tour(int first, int last, bool mirrored = false) {
  std::vector<Eigen::Vector2d> corners;
  const int step = first <= last ? 1 : -1;
  for (int i = first; i != last + step; i += step) {
    const double x = 8.0 * i + 4.0;
    const Eigen::Vector2d door(x, 0.0), above(x, 3.0), below(x, -3.2);
    corners.insert(corners.end(), {door, above, door, below, door});
  }
  if (mirrored) {
    for (Eigen::Vector2d& corner : corners) corner.y() = -corner.y();
  }
  return along(corners);
}

/// A laser that sees around itself.
struct Laser {
  int beams = 180;
  double max_range_m = 12.0;
};

/// What a vehicle maps on the way. It begins at its first pose, and drifts.
inline VehicleMap mapOf(const std::string& name, const Variant& variant,
                        const std::vector<Pose2>& way, const Laser& laser = {}) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  loop_world::Drive drive(walls(variant), 0.0002);
  drive.beams = laser.beams;
  drive.max_range_m = laser.max_range_m;
  for (const Pose2& pose : way) drive.add(pose, graph);
  graph.finish();
  return vehicleMapOf(name, graph);
}

/// What `map` was when it had only `count` keyframes.
inline VehicleMap beginOf(VehicleMap map, std::size_t count) {
  map.keyframes.resize(count);
  map.poses.resize(count);
  map.places = {{0, 0, count}};
  map.edges.erase(
      std::remove_if(map.edges.begin(), map.edges.end(),
                     [&](const PoseEdge& e) { return e.from >= count || e.to >= count; }),
      map.edges.end());
  return map;
}

}  // namespace kestrel::building
