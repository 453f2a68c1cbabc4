// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "built_in_places.h"
#include "kestrel_slam/geometry/random.h"
#include "place_parts.h"

namespace kestrel {
namespace {

constexpr double kCorridorFlightHeight = 1.0;  // m

/// A closed door, slightly behind the face of its wall.
Opening closedDoor(double at, Random& random) {
  constexpr double kDoorWidths[] = {0.9, 1.0, 1.2, 1.6};
  const double width = kDoorWidths[static_cast<std::size_t>(random.uniform(0.0, 4.0))];
  return {at, width, random.uniform(0.08, 0.25)};
}

/// Adds a random object that stands at or hangs on a corridor wall.
void addFitting(World::Parts& parts, const WallLine& line, double at, Random& random) {
  constexpr int kKinds = 5;
  switch (static_cast<int>(random.uniform(0.0, kKinds))) {
    case 0:  // a pillar
      addAgainst(parts, line, at,
                 {random.uniform(0.3, 0.6), random.uniform(0.12, 0.3), line.height});
      break;
    case 1:  // a radiator; its top is just above the flight height
      addAgainst(parts, line, at, {random.uniform(0.8, 1.4), 0.12, 1.15}, 0.1);
      break;
    case 2:  // a cabinet
      addAgainst(parts, line, at, {random.uniform(0.6, 1.2), random.uniform(0.3, 0.42), 1.9});
      break;
    case 3:  // a notice board
      addAgainst(parts, line, at, {random.uniform(0.8, 1.4), 0.04, 1.0}, 0.8);
      break;
    default:  // a plant
      addPole(parts, line.at(at, 0.22), random.uniform(0.12, 0.2), random.uniform(1.2, 1.6));
      break;
  }
}

/// Adds a corridor wall with a door or a fitting every few meters, but none in the first and last
/// `ends` meters.
void addCorridorWall(World::Parts& parts, const WallLine& line, double ends, Random& random) {
  constexpr double kShortestStep = 2.2, kLongestStep = 4.2;  // m
  constexpr double kDoorShare = 0.5;
  std::vector<Opening> doors;
  for (double at = ends + random.uniform(0.0, 1.0); at < line.length() - ends;
       at += random.uniform(kShortestStep, kLongestStep)) {
    if (random.uniform() < kDoorShare) {
      doors.push_back(closedDoor(at, random));
    } else {
      addFitting(parts, line, at, random);
    }
  }
  addWall(parts, line, doors);
}

/// The corners of a square around the origin, counterclockwise from the lower left.
std::vector<Eigen::Vector2d> square(double half_width) {
  return {{-half_width, -half_width},
          {half_width, -half_width},
          {half_width, half_width},
          {-half_width, half_width}};
}

}  // namespace

Place corridorRing() {
  constexpr double kOuter = 25.0, kInner = 22.5, kCenterLine = 23.75;  // m from the middle
  constexpr double kCorner = 3.8;  // m of the outer walls that belong to the neighboring corridors
  constexpr std::uint64_t kSeed = 5;
  Place ring;
  ring.name = "ring";
  ring.description = "ring of office corridors, 50 m x 50 m, 2.5 m wide, one loop at 1 m/s";
  ring.parts.ceiling_m = 2.8;
  Random random(kSeed);
  const std::vector<Eigen::Vector2d> outer = square(kOuter), inner = square(kInner);
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const std::size_t next = (i + 1) % outer.size();
    addCorridorWall(ring.parts, {outer[i], outer[next], ring.parts.ceiling_m}, kCorner, random);
    addCorridorWall(ring.parts, {inner[next], inner[i], ring.parts.ceiling_m}, 1.0, random);
  }
  // One loop from the middle of one side, and 8 m more, so that the first part is seen again.
  const double c = kCenterLine, z = kCorridorFlightHeight;
  ring.plan.waypoints = alongLines(
      {{0, -c, z}, {c, -c, z}, {c, c, z}, {-c, c, z}, {-c, -c, z}, {0, -c, z}, {8, -c, z}}, 1.0);
  ring.plan.speed_m_s = 1.0;
  ring.plan.nose_forward = true;
  return ring;
}

Place straightCorridor() {
  constexpr double kLength = 60.0, kHalfWidth = 1.25;  // m
  Place corridor;
  corridor.name = "corridor";
  corridor.description = "straight corridor of 60 m with four doors and bare walls, at 1 m/s";
  World::Parts& parts = corridor.parts;
  const WallLine right = {{0.0, -kHalfWidth}, {kLength, -kHalfWidth}, parts.ceiling_m};
  const WallLine left = {{kLength, kHalfWidth}, {0.0, kHalfWidth}, parts.ceiling_m};
  addWall(parts, right, {{11.0, 1.0, 0.2}, {38.0, 1.0, 0.15}});
  addWall(parts, left, {{kLength - 47.0, 1.2, 0.2}, {kLength - 24.0, 1.0, 0.2}});
  addWall(parts, {right.to, left.from, parts.ceiling_m});
  addWall(parts, {left.to, right.from, parts.ceiling_m});
  corridor.plan.waypoints =
      alongLines({{3, 0, kCorridorFlightHeight}, {57, 0, kCorridorFlightHeight}}, 1.0);
  corridor.plan.speed_m_s = 1.0;
  corridor.plan.nose_forward = true;
  return corridor;
}

Place hall() {
  constexpr double kHalfWidth = 40.0, kPillar = 0.6, kPillarsEvery = 20.0;  // m
  Place hall;
  hall.name = "hall";
  hall.description =
      "hall of 80 m x 80 m with few pillars; the flight leaves the wall and returns to it";
  hall.parts.ceiling_m = 8.0;
  const std::vector<WallLine> walls = addRoom(hall.parts, square(kHalfWidth), hall.parts.ceiling_m);
  for (double x = -kHalfWidth + kPillarsEvery; x < kHalfWidth; x += kPillarsEvery) {
    for (double y = -kHalfWidth + kPillarsEvery; y < kHalfWidth; y += kPillarsEvery) {
      addBlock(hall.parts, {x, y}, {kPillar, kPillar, hall.parts.ceiling_m});
    }
  }
  for (const double along : {17.0, 26.0, 49.5, 66.0}) {  // gates and switch cabinets
    addAgainst(hall.parts, walls[0], along, {1.5, 0.5, 2.0});
    addAgainst(hall.parts, walls[1], along, {3.0, 0.25, 4.0});
  }
  const double z = 1.5, wall = -37.0;
  hall.plan.waypoints =
      alongLines({{-35, wall, z}, {-7, wall, z}, {-7, 7, z}, {9, 7, z}, {9, wall, z}}, 1.5);
  hall.plan.speed_m_s = 1.5;
  return hall;
}

}  // namespace kestrel
