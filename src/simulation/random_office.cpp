// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/simulation/random_office.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "place_parts.h"

namespace kestrel {
namespace {

constexpr double kHalfWidth = 1.2;  // of the corridor, m
constexpr double kThickness = 0.15, kDoorWidth = 1.2;
constexpr double kFlightHeight = 1.0;
constexpr double kChangedDepth = 1.2;
constexpr double kDoorHeight = 2.1, kHighestInDoor = 1.4;
// Doors between two rooms: from the corridor to the middle, behind the furniture at the side walls.
constexpr double kInnerDoor = 4.3, kInnerWidth = 1.4, kDeeper = 2.0;

struct Room {
  double west, east;  ///< x of its side walls, m
  double depth;
  double door;  ///< x of the middle of its door
  double side;  ///< 1: north of the corridor, -1: south
  Random random;

  double width() const { return east - west; }
  double y(double from_corridor) const { return side * (kHalfWidth + from_corridor); }
  /// A random x beside the way from the door into the room.
  double xBesideWay(double half_size) {
    const double margin = half_size + 0.7;
    const double left = door - margin - west - half_size, right = east - door - margin - half_size;
    const double at = random.uniform(0.0, std::max(left, 0.0) + std::max(right, 0.0));
    return at < left ? west + half_size + at : east - half_size - (at - std::max(left, 0.0));
  }
};

void addBox(World::Parts& parts, const Room& room, double x, double from_corridor, double width,
            double depth, double height) {
  addBlock(parts, {x, room.y(from_corridor)}, {width, depth, height});
}

void addFurniture(World::Parts& parts, Room& room) {
  Random& random = room.random;
  for (int i = 0; i < 2; ++i) {  // at the back wall
    const double width = random.uniform(0.5, 1.2), depth = random.uniform(0.3, 0.6);
    addBox(parts, room, room.xBesideWay(0.5 * width), room.depth - 0.5 * depth, width, depth, 2.0);
  }
  const double length = random.uniform(0.6, 1.4), along = random.uniform(1.0, 2.5);
  const bool east = random.uniform() < 0.5;
  addBox(parts, room, east ? room.east - 0.25 : room.west + 0.25, along, 0.35, length, 1.8);
  const double size = random.uniform(0.3, 0.7);  // free
  const double x = room.xBesideWay(0.5 * size);
  addBox(parts, room, x, random.uniform(1.2, room.depth - 1.5), size, 0.5, 1.4);
}

/// A wall between two rooms, with a door.
void addInnerDoor(World::Parts& parts, const Room& room, double x) {
  const double near = kInnerDoor - 0.5 * kInnerWidth, far = kInnerDoor + 0.5 * kInnerWidth;
  addBox(parts, room, x, 0.5 * near, kThickness, near, parts.ceiling_m);
  addBox(parts, room, x, 0.5 * (far + room.depth), kThickness, room.depth - far, parts.ceiling_m);
  addBlock(parts, {x, room.y(kInnerDoor)}, {kThickness, kInnerWidth, parts.ceiling_m - kDoorHeight},
           0.0, kDoorHeight);
}

/// Which walls of a room have a door to the next room, and whether doors have a lintel.
struct Doors {
  bool west = false, east = false, lintels = false;
};

void addRoom(World::Parts& parts, Room room, OfficeChange change, const Doors& doors) {
  if (change == OfficeChange::kFurniture) room.random = Random(4711);
  if (change == OfficeChange::kShallow) room.depth -= kChangedDepth;
  if (change == OfficeChange::kDeep) room.depth += kChangedDepth;
  const double height = parts.ceiling_m;
  for (const double x : {room.west, room.east}) {
    if (x == room.west ? doors.west : doors.east) {
      addInnerDoor(parts, room, x);
    } else {
      addBox(parts, room, x, 0.5 * room.depth, kThickness, room.depth, height);
    }
  }
  addBox(parts, room, 0.5 * (room.west + room.east), room.depth, room.width(), kThickness, height);
  // Front: a wall on both sides of the door.
  const double left = room.door - 0.5 * kDoorWidth, right = room.door + 0.5 * kDoorWidth;
  addBox(parts, room, 0.5 * (room.west + left), 0.0, left - room.west, kThickness, height);
  addBox(parts, room, 0.5 * (right + room.east), 0.0, room.east - right, kThickness, height);
  if (doors.lintels)
    addBlock(parts, {room.door, room.y(0.0)}, {kDoorWidth, kThickness, height - kDoorHeight}, 0.0,
             kDoorHeight);
  if (change == OfficeChange::kPartition) {
    const bool east = room.east - room.door > room.door - room.west;
    const double length = 0.6 * room.depth;
    addBox(parts, room, room.door + (east ? 1.1 : -1.1), room.depth - 0.5 * length, kThickness,
           length, height);
  }
  addFurniture(parts, room);
}

/// The first half of the rooms is north of the corridor.
std::vector<Room> roomsOf(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<Room> rooms;
  double x = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == count / 2) x = 0.0;
    const double width = random.uniform(4.5, 7.0), depth = random.uniform(4.2, 6.0);
    const double door = x + random.uniform(1.6, width - 1.6);
    rooms.push_back(
        {x, x + width, depth, door, i < count / 2 ? 1.0 : -1.0, Random(1000 * seed + i)});
    x += width;
  }
  return rooms;
}

/// The ends of the corridor, its wall beside the last room of the shorter side, and cabinets.
void addCorridor(World::Parts& parts, const std::vector<Room>& rooms, std::uint64_t seed) {
  const Room& last_north = rooms[rooms.size() / 2 - 1];
  const double north = last_north.east, south = rooms.back().east;
  const double length = std::max(north, south), height = parts.ceiling_m;
  for (const double x : {0.0, length})
    addBlock(parts, {x, 0.0}, {kThickness, 2.0 * kHalfWidth, height});
  const Room& shorter = north < south ? last_north : rooms.back();
  const double rest = length - shorter.east;
  addBox(parts, shorter, shorter.east + 0.5 * rest, 0.0, rest, kThickness, height);
  Random random(2000 + seed);
  for (const Room& room : rooms) {
    const double width = random.uniform(0.3, 0.6);
    const bool east = room.east - room.door > room.door - room.west;
    addBox(parts, room, east ? room.east - 0.5 : room.west + 0.5, -0.15, width, 0.3, 1.9);
  }
}

/// All rooms, in a random order along the corridor.
std::vector<std::size_t> orderOf(const std::vector<Room>& rooms, std::uint64_t route) {
  std::vector<std::size_t> order(rooms.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rooms[a].door < rooms[b].door; });
  if (route % 2 == 1) std::reverse(order.begin(), order.end());
  const auto half = static_cast<std::ptrdiff_t>(order.size() / 2);
  if (route > 2) std::rotate(order.begin(), order.begin() + half, order.end());
  return order;
}

/// From the corridor into all rooms, at one height.
std::vector<Eigen::Vector3d> levelWay(const std::vector<Room>& rooms, std::uint64_t route) {
  std::vector<Eigen::Vector3d> corners;
  for (const std::size_t i : orderOf(rooms, route)) {
    const Room& room = rooms[i];
    const Eigen::Vector3d door(room.door, 0.0, kFlightHeight);
    const Eigen::Vector3d inside(room.door, room.y(0.55 * room.depth), kFlightHeight);
    corners.insert(corners.end(), {door, inside, door});
  }
  return corners;
}

/// The same at other heights, but low at the doors.
std::vector<Eigen::Vector3d> wayAtHeights(const std::vector<Room>& rooms, std::uint64_t route,
                                          const FlightHeights& heights, Random random) {
  std::vector<Eigen::Vector3d> corners;
  const auto height = [&] { return random.uniform(heights.lowest, heights.highest); };
  for (const std::size_t i : orderOf(rooms, route)) {
    const Room& room = rooms[i];
    const double low = std::min(heights.lowest, kHighestInDoor);
    const Eigen::Vector3d door(room.door, 0.0, low), behind(room.door, room.y(0.6), low);
    const Eigen::Vector2d inside(room.door, room.y(0.55 * room.depth));
    if (!corners.empty()) {
      const Eigen::Vector3d before = corners.back();
      corners.push_back(0.5 * (before + door));
      corners.back().z() = height();
    }
    corners.insert(corners.end(), {door,
                                   behind,
                                   {inside.x(), inside.y(), height()},
                                   {inside.x(), inside.y(), height()},
                                   behind,
                                   door});
  }
  return corners;
}

FlightPlan planOf(const std::vector<Eigen::Vector3d>& corners, std::uint64_t route) {
  FlightPlan plan;
  plan.waypoints = alongLines(corners, 0.7);
  // Lasers look forward: the walls in the north and in the south are seen with both headings.
  const double yaw = degToRad(20.0) + (route % 2 == 1 ? kPi : 0.0);
  for (FlightPlan::Waypoint& waypoint : plan.waypoints) waypoint.yaw = yaw;
  plan.speed_m_s = 0.8;
  return plan;
}

}  // namespace

const char* toString(OfficeChange change) {
  switch (change) {
    case OfficeChange::kFurniture:
      return "other furniture";
    case OfficeChange::kShallow:
      return "shallower room";
    case OfficeChange::kDeep:
      return "deeper room";
    case OfficeChange::kPartition:
      return "partition";
    case OfficeChange::kDoor:
      return "no door";
    default:
      return "the same";
  }
}

namespace {

Place emptyOffice(std::uint64_t seed) {
  Place office;
  office.name = "office " + std::to_string(seed);
  office.description = "a corridor with random rooms on both sides";
  return office;
}

}  // namespace

Place randomOffice(std::uint64_t seed, OfficeChange change, std::uint64_t route,
                   std::size_t count) {
  Place office = emptyOffice(seed);
  const std::vector<Room> rooms = roomsOf(seed, std::max<std::size_t>(count, 2));
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const bool changed = i == seed % rooms.size();
    addRoom(office.parts, rooms[i], changed ? change : OfficeChange::kNone, {});
  }
  addCorridor(office.parts, rooms, seed);
  office.plan = planOf(levelWay(rooms, route), route);
  return office;
}

Place officeWithDoors(std::uint64_t seed, OfficeChange change, std::uint64_t route,
                      const FlightHeights& heights) {
  constexpr std::size_t kRooms = 6, kOnOneSide = 3;
  Place office = emptyOffice(seed);
  std::vector<Room> rooms = roomsOf(seed, kRooms);
  for (Room& room : rooms) room.depth += kDeeper;
  const std::size_t changed = seed % kRooms;
  // Between the rooms i and i + 1.
  const auto hasDoor = [&](std::size_t i) {
    const std::size_t missing = changed % kOnOneSide == 0 ? changed : changed - 1;
    return i % kOnOneSide + 1 < kOnOneSide && !(change == OfficeChange::kDoor && i == missing);
  };
  for (std::size_t i = 0; i < kRooms; ++i) {
    const Doors doors{i > 0 && hasDoor(i - 1), hasDoor(i), true};
    addRoom(office.parts, rooms[i], i == changed ? change : OfficeChange::kNone, doors);
  }
  addCorridor(office.parts, rooms, seed);
  office.plan =
      planOf(wayAtHeights(rooms, route, heights, Random(3000 + 10 * seed + route)), route);
  return office;
}

}  // namespace kestrel
