// SPDX-License-Identifier: BSD-3-Clause
#include "built_in_places.h"
#include "place_parts.h"

namespace kestrel {
namespace {

constexpr double kLength = 45.0, kWidth = 2.5;      // of a corridor, m
constexpr double kRoomWidth = 5.0, kRoomDepth = 4;  // m
constexpr int kTwinRooms = 6;
constexpr double kFirstRoom = 7.5, kLastRoom = kFirstRoom + kTwinRooms * kRoomWidth;  // x, m
constexpr double kBetween = 2.0;  // solid part between a corridor and the rooms of the next one, m

/// A corridor whose southern wall is at `y`, with identical rooms in the south.
void addCorridor(World::Parts& parts, double y) {
  const double height = parts.ceiling_m, middle = y - kRoomDepth / 2.0;
  std::vector<Opening> doors;
  for (int room = 0; room < kTwinRooms; ++room) {
    const double x = kFirstRoom + kRoomWidth * room;
    doors.push_back({kRoomWidth * room + 2.0, 1.4});
    addBlock(parts, {x, middle}, {0.2, kRoomDepth, height});
    addBlock(parts, {x + 1.0, y - 3.4}, {1.6, 0.8, 1.3});   // desk
    addBlock(parts, {x + 4.3, y - 2.6}, {0.5, 1.4, 1.9});   // shelf
    addBlock(parts, {x + 3.4, y + 2.35}, {0.8, 0.3, 2.0});  // cabinet in the corridor
  }
  addWall(parts, {{kFirstRoom, y}, {kLastRoom, y}, height}, doors);
  addBlock(parts, {kLastRoom, middle}, {0.2, kRoomDepth, height});
}

}  // namespace

Place twins() {
  constexpr double kPitch = kWidth + kBetween + kRoomDepth, z = 1.0;
  Place twins;
  twins.name = "twins";
  twins.description =
      "two identical corridors side by side, each with six identical rooms; two loops at 1 m/s, "
      "always with the same heading";
  World::Parts& parts = twins.parts;
  const double height = parts.ceiling_m, north = kPitch + kWidth;
  addRoom(parts, {{0, -kRoomDepth}, {kLength, -kRoomDepth}, {kLength, north}, {0, north}}, height);
  addCorridor(parts, 0.0);
  addCorridor(parts, kPitch);
  const double end = (kLength - kLastRoom) / 2.0;  // solid parts beside the rooms
  const double inner_y = (kWidth + kPitch) / 2.0, inner_depth = kPitch - kWidth;
  addBlock(parts, {kFirstRoom / 2.0, -kRoomDepth / 2.0}, {kFirstRoom, kRoomDepth, height});
  addBlock(parts, {kLastRoom + end, -kRoomDepth / 2.0}, {2.0 * end, kRoomDepth, height});
  addBlock(parts, {kLength / 2.0, kWidth + kBetween / 2.0},
           {kLength - 2.0 * kWidth, kBetween, height});
  addBlock(parts, {(kWidth + kFirstRoom) / 2.0, inner_y},
           {kFirstRoom - kWidth, inner_depth, height});
  addBlock(parts, {(kLastRoom + kLength - kWidth) / 2.0, inner_y},
           {kLength - kWidth - kLastRoom, inner_depth, height});
  std::vector<Eigen::Vector3d> corners;
  const double lane = kWidth / 2.0 - 0.2;
  for (int loop = 0; loop < 2; ++loop) {
    corners.push_back({lane, lane, z});
    for (const double x : {kFirstRoom + 2.0, kFirstRoom + 2.0 * kRoomWidth + 2.0}) {
      for (const double y : {lane, -1.6, lane}) corners.push_back({x, y, z});
    }
    corners.push_back({kLength - lane, lane, z});
    corners.push_back({kLength - lane, kPitch + lane, z});
    for (const double x : {kFirstRoom + 3.0 * kRoomWidth + 2.0, kFirstRoom + kRoomWidth + 2.0}) {
      for (const double y : {lane, -1.6, lane}) corners.push_back({x, kPitch + y, z});
    }
    corners.push_back({lane, kPitch + lane, z});
  }
  twins.plan.waypoints = alongLines(corners, 0.7);
  twins.plan.speed_m_s = 1.0;
  return twins;
}

}  // namespace kestrel
