// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/simulation/flight_plan.h"

namespace kestrel {

/// A straight wall; what is set against it, and where one looks at it from, is to its left.
struct WallLine {
  Eigen::Vector2d from, to;
  double height = 3.0;     ///< m
  double thickness = 0.3;  ///< to the right of the line; deeper than a closed door lies
  Material material = Material::kMatt;

  /// The point `along` the line and `aside` to its left, m.
  Eigen::Vector2d at(double along, double aside) const;
  double yaw() const;
  double length() const { return (to - from).norm(); }
};

/// A gap in a wall up to the height of a door.
struct Opening {
  double at;           ///< of its middle, along the wall, m
  double width = 1.0;  ///< m
  double leaf_depth =
      0.0;  ///< of the closed door behind the wall's face, m; 0: one can fly through
};

/// The wall with openings that do not overlap, in the order along it.
void addWall(World::Parts& parts, const WallLine& line, const std::vector<Opening>& openings = {});

/// Something of the size (along the wall, off the wall, upwards) against the wall, its middle at
/// `along`, its underside at `bottom`.
void addAgainst(World::Parts& parts, const WallLine& line, double along,
                const Eigen::Vector3d& size, double bottom = 0.0,
                Material material = Material::kMatt);

/// A closed room: walls along the polygon `corners`, counterclockwise. The result are its walls.
std::vector<WallLine> addRoom(World::Parts& parts, const std::vector<Eigen::Vector2d>& corners,
                              double height);

/// A box that stands on the floor or hangs at `bottom`; `size` along its own axes.
void addBlock(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector3d& size,
              double yaw = 0.0, double bottom = 0.0, Material material = Material::kMatt);

/// A table with a flat top at the height of 0.74 m and four legs.
void addTable(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector2d& size,
              double yaw = 0.0);
/// A chair that looks along `yaw`: a seat, a back and four legs.
void addChair(World::Parts& parts, const Eigen::Vector2d& center, double yaw);
/// A lamp on a cord; its shade begins at `bottom`.
void addLamp(World::Parts& parts, const Eigen::Vector2d& center, double bottom);
void addPole(World::Parts& parts, const Eigen::Vector2d& center, double radius, double top);

/// Waypoints on the straight lines from corner to corner, about `spacing` apart: a smooth path
/// through them keeps to the lines and rounds the corners.
std::vector<FlightPlan::Waypoint> alongLines(const std::vector<Eigen::Vector3d>& corners,
                                             double spacing);
/// The same, back to the first corner.
std::vector<FlightPlan::Waypoint> aroundLoop(std::vector<Eigen::Vector3d> corners, double spacing);

}  // namespace kestrel
