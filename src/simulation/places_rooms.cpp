// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "built_in_places.h"
#include "kestrel_slam/geometry/angles.h"
#include "place_parts.h"

namespace kestrel {
namespace {

constexpr double kRoomFlightHeight = 1.0;  // m
constexpr double kSpacing = 0.7;           // m between the waypoints of a room

std::vector<Eigen::Vector2d> rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}

/// A table with chairs at its long sides.
void addMeetingTable(World::Parts& parts, const Eigen::Vector2d& center) {
  addTable(parts, center, {2.0, 1.0});
  for (const double x : {-0.6, 0.1, 0.7}) {
    addChair(parts, center + Eigen::Vector2d(x, 0.75), -kPi / 2.0);
    addChair(parts, center - Eigen::Vector2d(x, 0.75), kPi / 2.0);
  }
}

}  // namespace

Place laboratory() {
  Place lab;
  lab.name = "laboratory";
  lab.description = "8 m x 8 m with furniture, one loop of 25 m at 0.5 m/s";
  World::Parts& parts = lab.parts;
  const WallLine south = {{-4, -4}, {4, -4}}, east = {{4, -4}, {4, 4}};
  const WallLine north = {{4, 4}, {-4, 4}}, west = {{-4, 4}, {-4, -4}};
  addWall(parts, south, {{5.6, 1.0, 0.18}});  // the door
  addWall(parts, east);
  addWall(parts, north);
  addWall(parts, west);
  addAgainst(parts, south, 1.6, {1.8, 0.4, 2.0});               // shelves
  addAgainst(parts, south, 3.9, {0.4, 0.25, parts.ceiling_m});  // pillar
  addAgainst(parts, east, 1.6, {1.2, 0.12, 1.2}, 0.1);          // radiator
  addAgainst(parts, east, 6.6, {0.9, 0.5, 1.9});                // cupboard
  addAgainst(parts, north, 1.2, {0.5, 0.35, 1.4});              // printer
  addAgainst(parts, north, 4.6, {2.4, 0.3, 1.6}, 0.9);          // wall cupboards over a bench
  addAgainst(parts, north, 4.6, {2.4, 0.6, 0.85});
  addAgainst(parts, west, 1.0, {0.3, 0.3, parts.ceiling_m});  // pillar
  addAgainst(parts, west, 3.3, {1.4, 0.35, 1.8});             // shelves
  addAgainst(parts, west, 6.2, {1.6, 0.04, 1.2}, 0.8);        // board
  addBlock(parts, {2.5, 0.0}, {2.4, 0.8, 0.85});              // desks in a row ...
  addBlock(parts, {2.6, 0.0}, {1.8, 0.08, 0.6}, 0.0, 0.85);   // ... with a screen between them
  addBlock(parts, {-1.3, 0.1}, {0.9, 2.0, 0.9});              // bench with instruments
  addBlock(parts, {-1.4, 0.6}, {0.5, 0.5, 0.5}, 0.4, 0.9);
  addBlock(parts, {-1.2, -0.4}, {0.6, 0.3, 0.4}, -0.2, 0.9);
  addPole(parts, {1.2, 1.95}, 0.06, parts.ceiling_m);
  addPole(parts, {0.8, -1.95}, 0.12, 1.6);  // gas bottle
  // Around the bench and the desks: a C-shaped loop of 25 m.
  const double o = 2.68, n = 1.2, z = kRoomFlightHeight;
  lab.plan.waypoints = aroundLoop({{-o, 0, z},
                                   {-o, -o, z},
                                   {o, -o, z},
                                   {o, -n, z},
                                   {0.2, -n, z},
                                   {0.2, n, z},
                                   {o, n, z},
                                   {o, o, z},
                                   {-o, o, z}},
                                  kSpacing);
  lab.plan.speed_m_s = 0.5;
  lab.plan.nose_forward = true;
  return lab;
}

Place cluttered() {
  Place room;
  room.name = "cluttered";
  room.description =
      "10 m x 8 m with tables, chairs, shelves and lamps, so that every height looks different; "
      "the flight climbs by 1.5 m";
  World::Parts& parts = room.parts;
  const std::vector<WallLine> walls = addRoom(parts, rectangle(-5, -4, 5, 4), parts.ceiling_m);
  for (const double along : {1.5, 2.9, 4.3}) addAgainst(parts, walls[0], along, {1.2, 0.4, 2.0});
  addAgainst(parts, walls[0], 7.4, {1.6, 0.5, 0.9});
  addAgainst(parts, walls[1], 2.0, {1.4, 0.12, 0.6}, 0.1);  // radiators
  addAgainst(parts, walls[1], 5.5, {1.4, 0.12, 0.6}, 0.1);
  addAgainst(parts, walls[1], 3.8, {0.4, 0.3, parts.ceiling_m});
  addAgainst(parts, walls[2], 2.0, {2.0, 0.35, 0.7}, 1.4);  // wall cupboards
  addAgainst(parts, walls[2], 5.2, {1.0, 0.6, 1.2});
  addAgainst(parts, walls[2], 8.2, {1.6, 0.4, 1.6});
  addAgainst(parts, walls[3], 1.6, {0.8, 0.6, 2.0});
  addAgainst(parts, walls[3], 4.4, {1.8, 0.05, 1.2}, 1.0);  // board
  addAgainst(parts, walls[3], 6.4, {0.8, 0.4, 1.1});
  addTable(parts, {-0.9, 0.3}, {1.8, 0.9}, 0.1);
  addTable(parts, {1.2, 0.1}, {1.6, 0.8}, -0.15);
  addChair(parts, {-1.2, 1.0}, -kPi / 2.0);
  addChair(parts, {-0.5, -0.5}, kPi / 2.0);
  addChair(parts, {1.0, 0.9}, -1.3);
  addChair(parts, {1.5, -0.7}, 1.9);
  addChair(parts, {-2.1, 0.2}, 0.3);
  addBlock(parts, {0.2, 0.3}, {0.35, 0.8, 2.0}, 0.4);  // a shelf between the tables
  addBlock(parts, {1.4, 0.1}, {0.5, 0.3, 0.5}, 0.2, 0.74);
  for (const double x : {-1.0, 1.3}) addLamp(parts, {x, 0.2}, 1.9);
  addLamp(parts, {4.3, 3.3}, 2.0);
  addLamp(parts, {-4.3, -3.3}, 2.05);
  // Two rounds around the tables; climbs by 1.5 m and descends again.
  const double x = 3.3, y = 2.2, low = 0.5, middle = 1.25, high = 2.0;
  room.plan.waypoints = alongLines({{-x, -y, low},
                                    {0, -y, low},
                                    {x, -y, middle},
                                    {x, y, high},
                                    {-x, y, high},
                                    {-x, -y, middle},
                                    {x, -y, low},
                                    {x, y, high},
                                    {-x, y, low},
                                    {-x, -y, low}},
                                   kSpacing);
  room.plan.speed_m_s = 0.6;
  return room;
}

Place glassOffice() {
  Place office;
  office.name = "glass";
  office.description = "12 m x 10 m office around a glass meeting room, with black cabinets";
  World::Parts& parts = office.parts;
  const std::vector<WallLine> walls = addRoom(parts, rectangle(-6, -5, 6, 5), parts.ceiling_m);
  const std::vector<Eigen::Vector2d> meeting_room = rectangle(-2, -1.5, 2, 1.5);
  for (std::size_t i = 0; i < meeting_room.size(); ++i) {
    // Seen from outside: clockwise.
    WallLine pane = {meeting_room[(i + 1) % meeting_room.size()], meeting_room[i], parts.ceiling_m};
    pane.thickness = 0.02;
    pane.material = Material::kGlass;
    addWall(parts, pane);
    addPole(parts, meeting_room[i], 0.05, parts.ceiling_m);
  }
  addMeetingTable(parts, {0.0, 0.0});
  for (const double along : {1.5, 2.7, 3.9}) {
    addAgainst(parts, walls[0], along, {1.1, 0.5, 1.9}, 0.0, Material::kBlack);
  }
  addAgainst(parts, walls[0], 8.5, {2.0, 0.8, 0.74});
  addAgainst(parts, walls[0], 8.2, {0.9, 0.3, 0.6}, 0.74);
  addAgainst(parts, walls[1], 2.2, {0.5, 0.3, parts.ceiling_m});
  addAgainst(parts, walls[1], 5.0, {2.2, 0.04, 1.6}, 0.6, Material::kBlack);  // a screen
  addAgainst(parts, walls[1], 8.0, {1.0, 0.4, 1.8});
  // A window front with frames; it is dark outside, so nothing is seen through it.
  addAgainst(parts, walls[2], 6.0, {6.0, 0.04, parts.ceiling_m}, 0.0, Material::kBlack);
  addBlock(parts, walls[2].at(6.0, 0.06), {6.0, 0.02, parts.ceiling_m}, walls[2].yaw(), 0.0,
           Material::kGlass);
  for (const double along : {3.0, 4.5, 6.0, 7.5, 9.0}) {
    addAgainst(parts, walls[2], along, {0.08, 0.12, parts.ceiling_m});
  }
  addAgainst(parts, walls[2], 1.2, {0.9, 0.45, 1.6});
  addAgainst(parts, walls[3], 2.5, {1.6, 0.7, 0.74});
  addAgainst(parts, walls[3], 2.2, {0.6, 0.3, 0.5}, 0.74);
  addAgainst(parts, walls[3], 5.0, {0.4, 0.3, parts.ceiling_m});
  addAgainst(parts, walls[3], 7.6, {1.2, 0.4, 1.9}, 0.0, Material::kBlack);
  const double x = 3.9, y = 3.0, z = kRoomFlightHeight;
  office.plan.waypoints =
      aroundLoop({{0, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}, {-x, -y, z}}, kSpacing);
  office.plan.speed_m_s = 0.5;
  office.plan.nose_forward = true;
  return office;
}

Place peopleRoom() {
  Place room;
  room.name = "people";
  room.description = "14 m x 10 m with furniture and four people who walk around the vehicle";
  World::Parts& parts = room.parts;
  const std::vector<WallLine> walls = addRoom(parts, rectangle(-7, -5, 7, 5), parts.ceiling_m);
  for (const double along : {1.8, 5.0, 9.2, 12.0}) {
    addAgainst(parts, walls[0], along, {1.2, 0.5, 1.8});
    addAgainst(parts, walls[2], along + 0.7, {1.5, 0.6, 1.2});
  }
  for (const double along : {2.1, 5.2, 8.0}) {
    addAgainst(parts, walls[1], along, {0.9, 0.4, 2.0});
    addAgainst(parts, walls[3], along - 0.4, {0.5, 0.3, parts.ceiling_m});
  }
  addBlock(parts, {0.0, 0.0}, {1.6, 0.5, 1.3}, 0.35);  // a display in the middle
  addPole(parts, {3.4, 2.5}, 0.15, parts.ceiling_m);
  addPole(parts, {-3.4, -2.5}, 0.15, parts.ceiling_m);
  parts.walkers = {{{{4.0, -3.2}, {5.8, -3.2}, {5.8, 3.2}, {4.0, 3.2}}, 1.2, 0.0},
                   {{{-4.0, 3.2}, {-5.8, 3.2}, {-5.8, -3.2}, {-4.0, -3.2}}, 0.9, 3.0},
                   {{{-2.5, 3.1}, {2.5, 3.1}, {2.0, 3.8}, {-2.0, 3.8}}, 1.0, 1.0},
                   {{{-2.0, -3.8}, {2.0, -3.8}, {2.5, -3.1}, {-2.5, -3.1}}, 1.4, 4.0}};
  const double x = 2.4, y = 1.7, z = kRoomFlightHeight;
  room.plan.waypoints =
      aroundLoop({{0, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}, {-x, -y, z}}, kSpacing);
  room.plan.speed_m_s = 0.5;
  room.plan.nose_forward = true;
  return room;
}

Place fourRooms() {
  Place rooms;
  rooms.name = "doors";
  rooms.description = "four rooms of 6 m x 5 m; the flight passes all doors and returns";
  World::Parts& parts = rooms.parts;
  const std::vector<WallLine> outer = addRoom(parts, rectangle(-6, -5, 6, 5), parts.ceiling_m);
  const double door = 1.4, half_thickness = 0.15;
  // The inner walls are centered on the axes.
  addWall(parts, {{-6, half_thickness}, {6, half_thickness}}, {{3.2, door}, {8.6, door}});
  addWall(parts, {{-half_thickness, -5}, {-half_thickness, 5}}, {{2.2, door}, {7.6, door}});
  addAgainst(parts, outer[0], 1.4, {1.2, 0.5, 1.8});
  addAgainst(parts, outer[0], 4.4, {0.4, 0.3, parts.ceiling_m});
  addAgainst(parts, outer[0], 7.7, {1.6, 0.6, 1.1});
  addAgainst(parts, outer[0], 10.9, {0.9, 0.4, 2.0});
  addAgainst(parts, outer[1], 1.9, {1.2, 0.12, 1.2}, 0.1);
  addAgainst(parts, outer[1], 3.9, {0.6, 0.5, 1.5});
  addAgainst(parts, outer[1], 7.3, {1.4, 0.4, 1.8});
  addAgainst(parts, outer[2], 1.5, {0.8, 0.5, 1.9});
  addAgainst(parts, outer[2], 4.4, {1.2, 0.3, 1.4}, 0.7);
  addAgainst(parts, outer[2], 8.2, {1.8, 0.5, 1.2});
  addAgainst(parts, outer[2], 11.0, {0.5, 0.5, parts.ceiling_m});
  addAgainst(parts, outer[3], 2.2, {1.0, 0.4, 1.8});
  addAgainst(parts, outer[3], 6.1, {0.3, 0.3, parts.ceiling_m});
  addAgainst(parts, outer[3], 8.4, {1.3, 0.5, 1.3});
  addBlock(parts, {-0.6, 1.0}, {0.5, 0.8, 1.6});
  addBlock(parts, {0.6, -0.9}, {0.7, 0.7, 1.3}, 0.3);
  addBlock(parts, {5.0, -0.7}, {0.9, 0.6, 1.2});
  addPole(parts, {-5.2, 0.8}, 0.15, parts.ceiling_m);
  addBlock(parts, {-4.6, -1.0}, {0.8, 0.5, 1.7});
  const double west = -2.8, east = 2.6, south = -2.8, north = 2.6, z = kRoomFlightHeight;
  rooms.plan.waypoints = aroundLoop(
      {{west, -1.6, z}, {west, south, z}, {east, south, z}, {east, north, z}, {west, north, z}},
      kSpacing);
  rooms.plan.speed_m_s = 0.5;
  rooms.plan.nose_forward = true;
  return rooms;
}

}  // namespace kestrel
