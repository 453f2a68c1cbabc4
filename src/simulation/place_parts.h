// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

/// A straight wall. The room is on the left side of the line.
struct WallLine {
  Eigen::Vector2d from, to;
  double height = 3.0;     ///< m
  double thickness = 0.3;  ///< to the right of the line; more than the depth of a closed door
  Material material = Material::kMatt;

  /// The point at distance `along` the line and `left` of it, m.
  Eigen::Vector2d at(double along, double left) const;
  double yaw() const;
  double length() const { return (to - from).norm(); }
};

/// An opening in a wall with the height of a door.
struct Opening {
  double at;           ///< position of its middle along the wall, m
  double width = 1.0;  ///< m
  /// Depth of the closed door behind the face of the wall, m; 0: open.
  double leaf_depth = 0.0;
};

/// Adds a wall. The openings must not overlap and must be sorted along the wall.
void addWall(World::Parts& parts, const WallLine& line, const std::vector<Opening>& openings = {});

/// Adds a box that touches the wall. `size`: along the wall, away from the wall, upwards. Its
/// middle is at `along`, its bottom at `bottom`.
void addAgainst(World::Parts& parts, const WallLine& line, double along,
                const Eigen::Vector3d& size, double bottom = 0.0,
                Material material = Material::kMatt);

/// Adds a closed room with walls along the counterclockwise polygon `corners`. Returns the walls.
std::vector<WallLine> addRoom(World::Parts& parts, const std::vector<Eigen::Vector2d>& corners,
                              double height);

/// Adds a box. `size` is along the axes of the box, `bottom` is its height above the floor.
void addBlock(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector3d& size,
              double yaw = 0.0, double bottom = 0.0, Material material = Material::kMatt);

/// Adds a table with a flat top 0.74 m high and four legs.
void addTable(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector2d& size,
              double yaw = 0.0);
/// Adds a chair that faces `yaw`: a seat, a back and four legs.
void addChair(World::Parts& parts, const Eigen::Vector2d& center, double yaw);
/// Adds a lamp on a cord; the lower end of its shade is at `bottom`.
void addLamp(World::Parts& parts, const Eigen::Vector2d& center, double bottom);
void addPole(World::Parts& parts, const Eigen::Vector2d& center, double radius, double top);

/// Waypoints on the straight lines between the corners, about `spacing` apart. A smooth path
/// through them stays close to the lines and rounds the corners.
std::vector<FlightPlan::Waypoint> alongLines(const std::vector<Eigen::Vector3d>& corners,
                                             double spacing);
/// As alongLines(), and back to the first corner.
std::vector<FlightPlan::Waypoint> aroundLoop(std::vector<Eigen::Vector3d> corners, double spacing);

}  // namespace kestrel
