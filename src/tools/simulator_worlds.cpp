#include <initializer_list>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/tools/simulator.h"

namespace kestrel_slam {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Walls from each point to the next.
void addPolyline(std::vector<Wall>& walls, const Points& points) {
  for (std::size_t i = 1; i < points.size(); ++i) walls.push_back({points[i - 1], points[i]});
}

/// A box with its sides parallel to the axes, between two opposite corners.
void addBox(std::vector<Wall>& walls, double x0, double y0, double x1, double y1) {
  addPolyline(walls, {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}});
}

/// A wall with niches (doors, cabinets) to the left of its direction.
void addWallWithNiches(std::vector<Wall>& walls, const Eigen::Vector2d& from,
                       const Eigen::Vector2d& to, std::initializer_list<double> niches_at,
                       double depth) {
  constexpr double kNicheWidth = 1.0;  // m, a door
  const Eigen::Vector2d along = (to - from).normalized();
  const Eigen::Vector2d inwards = depth * Eigen::Vector2d(-along.y(), along.x());
  Points points = {from};
  for (const double start : niches_at) {
    const Eigen::Vector2d a = from + start * along, b = a + kNicheWidth * along;
    points.insert(points.end(), {a, a + inwards, b + inwards, b});
  }
  points.push_back(to);
  addPolyline(walls, points);
}

/// Points on the sides of a square around the origin, counterclockwise, `per_side` on each.
Points squareRoute(double half_width, int per_side) {
  Points points;
  for (const Eigen::Vector2d& corner : Points{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Eigen::Vector2d next(-corner.y(), corner.x());
    for (int i = 0; i < per_side; ++i) {
      const double fraction = static_cast<double>(i) / per_side;
      points.push_back(half_width * (corner + fraction * (next - corner)));
    }
  }
  return points;
}

SimulatedWorld laboratory() {
  SimulatedWorld world;
  world.name = "laboratory";
  world.description = "8 m x 8 m with furniture, one loop of 25 m at 0.5 m/s";
  world.speed_m_s = 0.5;
  addBox(world.walls, -4.0, -4.0, 4.0, 4.0);
  addBox(world.walls, -1.5, -1.2, -0.3, 0.6);                             // bench
  addBox(world.walls, 0.4, -0.9, 1.6, -0.2);                              // table
  addPolyline(world.walls, {{0.2, 1.9}, {0.9, 1.2}, {1.5, 1.8}});         // screen
  addBox(world.walls, -4.0, 1.0, -3.75, 2.2);                             // shelves
  addBox(world.walls, 0.6, 3.7, 1.8, 4.0);                                // cupboard
  addBox(world.walls, 3.8, -2.4, 4.0, -1.1);                              // radiator
  addPolyline(world.walls, {{-2.3, -4.0}, {-2.0, -3.75}, {-1.7, -4.0}});  // pillar
  addPolyline(world.walls, {{3.4, 4.0}, {4.0, 3.4}});                     // cut corner
  addBox(world.walls, 1.9, -2.2, 2.2, -1.9);                              // column
  constexpr double kHalfWidth = 3.27;  // m: the curve through it is 25 m long
  world.flight_corners = squareRoute(kHalfWidth, 6);
  return world;
}

SimulatedWorld corridors() {
  SimulatedWorld world;
  world.name = "corridors";
  world.description = "ring of office corridors, 50 m x 50 m, 2.5 m wide, one loop at 1 m/s";
  world.speed_m_s = 1.0;
  constexpr double kOuter = 25.0, kInner = 22.5;          // m from the centre
  constexpr double kOuterDoor = -0.25, kInnerDoor = 0.2;  // m, doors lie behind the walls
  std::vector<Wall>& walls = world.walls;
  addWallWithNiches(walls, {-kOuter, -kOuter}, {kOuter, -kOuter}, {4, 9.5, 17, 22, 31.5, 43},
                    kOuterDoor);
  addWallWithNiches(walls, {kOuter, -kOuter}, {kOuter, kOuter}, {6, 14, 21.5, 27, 38, 44.5},
                    kOuterDoor);
  addWallWithNiches(walls, {kOuter, kOuter}, {-kOuter, kOuter}, {3, 12, 19, 30.5, 36, 45},
                    kOuterDoor);
  addWallWithNiches(walls, {-kOuter, kOuter}, {-kOuter, -kOuter}, {7.5, 13, 24, 29, 37.5, 42},
                    kOuterDoor);
  addWallWithNiches(walls, {-kInner, -kInner}, {kInner, -kInner}, {5, 16, 24.5, 33, 39},
                    kInnerDoor);
  addWallWithNiches(walls, {kInner, -kInner}, {kInner, kInner}, {3.5, 11, 19, 30, 41}, kInnerDoor);
  addWallWithNiches(walls, {kInner, kInner}, {-kInner, kInner}, {8, 14, 26.5, 32, 40}, kInnerDoor);
  addWallWithNiches(walls, {-kInner, kInner}, {-kInner, -kInner}, {2.5, 10, 18, 28, 35.5},
                    kInnerDoor);
  addBox(walls, -8.0, -25.0, -7.6, -24.5);  // a column, a copier and two cabinets
  addBox(walls, 24.4, 2.0, 25.0, 3.3);
  addBox(walls, 9.0, 24.6, 10.2, 25.0);
  addBox(walls, -25.0, -11.0, -24.5, -10.2);
  constexpr double kCentreLine = (kOuter + kInner) / 2.0;
  world.flight_corners = squareRoute(kCentreLine, 24);
  return world;
}

LaserModel utm30lx() {
  LaserModel laser;
  laser.name = "utm30lx";
  laser.description = "Hokuyo UTM-30LX: 1081 beams, 270 deg, 40 Hz, 30 m";
  laser.beams = 1081;
  laser.angle_min = degToRad(-135.0);
  laser.angle_increment = degToRad(0.25);
  laser.rate_hz = 40.0;
  laser.time_increment = 1.0 / laser.rate_hz / 1440.0;  // 1440 steps are one turn of the mirror
  laser.range_min = 0.1;
  laser.range_max = 30.0;
  laser.sigma_m = 0.01;
  laser.resolution_m = 0.001;
  laser.dropout_probability = 0.005;
  laser.base_T_laser = Pose2(0.08, 0.0, 0.0);
  return laser;
}

LaserModel urg04lx() {
  LaserModel laser;
  laser.name = "urg04lx";
  laser.description = "Hokuyo URG-04LX: 682 beams, 240 deg, 10 Hz, 5.6 m";
  laser.beams = 682;
  laser.angle_increment = 2.0 * kPi / 1024.0;
  laser.angle_min = -340.5 * laser.angle_increment;
  laser.rate_hz = 10.0;
  laser.time_increment = 1.0 / laser.rate_hz / 1024.0;  // 1024 steps are one turn of the mirror
  laser.range_min = 0.06;
  laser.range_max = 5.6;
  laser.sigma_m = 0.02;
  laser.resolution_m = 0.001;
  laser.dropout_probability = 0.02;
  laser.base_T_laser = Pose2(0.08, 0.0, 0.0);
  return laser;
}

LaserModel sick180() {
  LaserModel laser;
  laser.name = "sick180";
  laser.description = "SICK LMS 200: 180 beams, 1 deg, 5 Hz as logged, 80 m";
  laser.beams = 180;
  laser.angle_min = degToRad(-90.0);
  laser.angle_increment = degToRad(1.0);
  laser.rate_hz = 5.0;
  laser.range_min = 0.02;
  laser.range_max = 80.0;
  laser.sigma_m = 0.01;
  laser.resolution_m = 0.01;
  return laser;
}

template <typename T>
const T& findByName(const std::vector<T>& items, const std::string& kind, const std::string& name) {
  std::string names;
  for (const T& item : items) {
    if (item.name == name) return item;
    names += (names.empty() ? "" : ", ") + item.name;
  }
  throw std::invalid_argument("unknown " + kind + " '" + name + "'; there are " + names);
}

}  // namespace

const std::vector<SimulatedWorld>& simulatedWorlds() {
  static const std::vector<SimulatedWorld> worlds = {laboratory(), corridors()};
  return worlds;
}

const std::vector<LaserModel>& laserModels() {
  static const std::vector<LaserModel> lasers = {utm30lx(), urg04lx(), sick180()};
  return lasers;
}

const SimulatedWorld& simulatedWorld(const std::string& name) {
  return findByName(simulatedWorlds(), "world", name);
}

const LaserModel& laserModel(const std::string& name) {
  return findByName(laserModels(), "sensor", name);
}

}  // namespace kestrel_slam
