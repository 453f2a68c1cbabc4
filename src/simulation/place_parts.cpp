// SPDX-License-Identifier: BSD-3-Clause
#include "place_parts.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr double kDoorHeight = 2.1;  // m
constexpr double kLeafThickness = 0.05;

/// The point (x, y) of an object with position `center` and orientation `yaw`, in world.
Eigen::Vector2d toWorld(const Eigen::Vector2d& center, double yaw, double x, double y) {
  return {center.x() + std::cos(yaw) * x - std::sin(yaw) * y,
          center.y() + std::sin(yaw) * x + std::cos(yaw) * y};
}

/// Adds the piece of the wall between the distances `from` and `to` along its line and between the
/// heights `bottom` and `top`.
void addPiece(World::Parts& parts, const WallLine& line, double from, double to, double bottom,
              double top) {
  addBlock(parts, line.at((from + to) / 2.0, -line.thickness / 2.0),
           {to - from, line.thickness, top - bottom}, line.yaw(), bottom, line.material);
}

}  // namespace

Eigen::Vector2d WallLine::at(double along, double left) const {
  return toWorld(from, yaw(), along, left);
}

double WallLine::yaw() const { return std::atan2(to.y() - from.y(), to.x() - from.x()); }

void addWall(World::Parts& parts, const WallLine& line, const std::vector<Opening>& openings) {
  double done = 0.0;
  for (const Opening& opening : openings) {
    const double left = opening.at - opening.width / 2.0, right = opening.at + opening.width / 2.0;
    addPiece(parts, line, done, left, 0.0, line.height);
    addPiece(parts, line, left, right, kDoorHeight, line.height);
    if (opening.leaf_depth > 0.0) {
      addBlock(parts, line.at(opening.at, -opening.leaf_depth - kLeafThickness / 2.0),
               {opening.width, kLeafThickness, kDoorHeight}, line.yaw());
    }
    done = right;
  }
  addPiece(parts, line, done, line.length(), 0.0, line.height);
}

void addAgainst(World::Parts& parts, const WallLine& line, double along,
                const Eigen::Vector3d& size, double bottom, Material material) {
  addBlock(parts, line.at(along, size.y() / 2.0), size, line.yaw(), bottom, material);
}

std::vector<WallLine> addRoom(World::Parts& parts, const std::vector<Eigen::Vector2d>& corners,
                              double height) {
  std::vector<WallLine> walls;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    walls.push_back({corners[i], corners[(i + 1) % corners.size()], height});
    addWall(parts, walls.back());
  }
  return walls;
}

void addBlock(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector3d& size,
              double yaw, double bottom, Material material) {
  parts.boxes.push_back({{center.x(), center.y(), bottom + size.z() / 2.0}, size, yaw, material});
}

void addTable(World::Parts& parts, const Eigen::Vector2d& center, const Eigen::Vector2d& size,
              double yaw) {
  constexpr double kTop = 0.74, kThickness = 0.03, kLegRadius = 0.03, kLegInset = 0.08;  // m
  addBlock(parts, center, {size.x(), size.y(), kThickness}, yaw, kTop - kThickness);
  const double x = size.x() / 2.0 - kLegInset, y = size.y() / 2.0 - kLegInset;
  for (const double side : {-1.0, 1.0}) {
    addPole(parts, toWorld(center, yaw, x, side * y), kLegRadius, kTop);
    addPole(parts, toWorld(center, yaw, -x, side * y), kLegRadius, kTop);
  }
}

void addChair(World::Parts& parts, const Eigen::Vector2d& center, double yaw) {
  constexpr double kSeat = 0.45, kWidth = 0.44, kThickness = 0.04, kBack = 0.9;  // m
  constexpr double kLegRadius = 0.02, kLegOffset = 0.19;
  addBlock(parts, center, {kWidth, kWidth, kThickness}, yaw, kSeat - kThickness);
  addBlock(parts, toWorld(center, yaw, -(kWidth - kThickness) / 2.0, 0.0),
           {kThickness, kWidth, kBack - kSeat}, yaw, kSeat);
  for (const double side : {-1.0, 1.0}) {
    addPole(parts, toWorld(center, yaw, kLegOffset, side * kLegOffset), kLegRadius, kSeat);
    addPole(parts, toWorld(center, yaw, -kLegOffset, side * kLegOffset), kLegRadius, kSeat);
  }
}

void addLamp(World::Parts& parts, const Eigen::Vector2d& center, double bottom) {
  constexpr double kShadeRadius = 0.2, kShadeHeight = 0.25, kCordRadius = 0.01;  // m
  parts.cylinders.push_back({center, kShadeRadius, bottom, bottom + kShadeHeight});
  parts.cylinders.push_back({center, kCordRadius, bottom + kShadeHeight, parts.ceiling_m});
}

void addPole(World::Parts& parts, const Eigen::Vector2d& center, double radius, double top) {
  parts.cylinders.push_back({center, radius, 0.0, top});
}

std::vector<FlightPlan::Waypoint> alongLines(const std::vector<Eigen::Vector3d>& corners,
                                             double spacing) {
  std::vector<FlightPlan::Waypoint> waypoints;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector3d line = corners[i] - corners[i - 1];
    const double pieces = std::max(std::round(line.norm() / spacing), 1.0);
    for (double piece = 0.0; piece < pieces; ++piece) {
      waypoints.push_back({corners[i - 1] + piece / pieces * line});
    }
  }
  waypoints.push_back({corners.back()});
  return waypoints;
}

std::vector<FlightPlan::Waypoint> aroundLoop(std::vector<Eigen::Vector3d> corners, double spacing) {
  corners.push_back(corners.front());
  return alongLines(corners, spacing);
}

}  // namespace kestrel
