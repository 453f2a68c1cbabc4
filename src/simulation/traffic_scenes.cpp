// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>

#include "find_by_name.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/simulation/traffic.h"

namespace kestrel {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using Speeds = std::vector<std::pair<double, double>>;

const Eigen::Vector3d kCar(4.4, 1.8, 1.5), kVan(5.2, 2.0, 2.3), kBus(11.0, 2.5, 3.0);
const Eigen::Vector3d kPerson(0.5, 0.5, 1.75), kBicycle(1.8, 0.6, 1.75);

Box wall(double x0, double x1, double y0, double y1, double height) {
  return {{0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * height},
          {std::abs(x1 - x0), std::abs(y1 - y0), height}};
}

/// Builds what stands along a street that runs along x; `turned`: along y.
class StreetBuilder {
 public:
  StreetBuilder(World::Parts& parts, std::uint64_t seed) : parts_(parts), random_(seed) {
    parts_.ceiling_m = std::numeric_limits<double>::infinity();
  }

  void turn(bool turned) { turned_ = turned; }

  void add(Box box) {
    if (turned_) {
      std::swap(box.center.x(), box.center.y());
      std::swap(box.size.x(), box.size.y());
    }
    parts_.boxes.push_back(box);
  }

  /// Houses of different heights, with pillars and doorways, from x0 to x1; the front at y.
  void houses(double x0, double x1, double y) {
    const double side = y > 0.0 ? 1.0 : -1.0;
    for (double x = x0; x < x1;) {
      const double end = std::min(x1, x + random_.uniform(9.0, 16.0));
      const double set_back = random_.uniform(0.0, 1.2), height = random_.uniform(6.0, 14.0);
      const double front = y + side * set_back;
      add(wall(x, end, front, front + side * 4.0, height));
      for (double pillar = x + 1.0; pillar < end - 0.5; pillar += random_.uniform(2.5, 5.0)) {
        add(wall(pillar, pillar + 0.5, front - side * 0.35, front, height));
      }
      x = end;
    }
  }

  void sidewalk(double x0, double x1, double y0, double y1) { add(wall(x0, x1, y0, y1, 0.12)); }

  /// Trees, lamps and boxes on the sidewalk.
  void furniture(double x0, double x1, double y) {
    for (double x = x0 + random_.uniform(2.0, 6.0); x < x1; x += random_.uniform(7.0, 12.0)) {
      const bool is_tree = random_.uniform() < 0.5;
      pole(x, y, is_tree ? 0.16 : 0.08, is_tree ? 3.0 : 6.0);
      if (is_tree) crown(x, y);
    }
  }

  void pole(double x, double y, double radius, double top) {
    parts_.cylinders.push_back(
        {turned_ ? Eigen::Vector2d(y, x) : Eigen::Vector2d(x, y), radius, 0.0, top});
  }

  void crown(double x, double y) {
    for (int i = 0; i < 8; ++i) {
      Box leaf = wall(0.0, 0.7, 0.0, 0.7, 0.6);
      leaf.center = {x + random_.uniform(-1.0, 1.0), y + random_.uniform(-1.0, 1.0),
                     random_.uniform(2.8, 4.4)};
      add(leaf);
    }
  }

  void parked(double x, double y, const Eigen::Vector3d& size) {
    const double x0 = x - 0.5 * size.x(), x1 = x + 0.5 * size.x();
    Box hull = wall(x0, x1, y - 0.5 * size.y(), y + 0.5 * size.y(), size.z());
    hull.size.z() = 0.6 * size.z() - 0.2;
    hull.center.z() = 0.2 + 0.5 * hull.size.z();
    add(hull);
    Box cabin = wall(x0 + 0.25 * size.x(), x1 - 0.2 * size.x(), y - 0.45 * size.y(),
                     y + 0.45 * size.y(), size.z());
    add(cabin);
    for (const double wheel : {x0 + 0.8, x1 - 0.8}) {
      add(wall(wheel - 0.3, wheel + 0.3, y - 0.48 * size.y(), y + 0.48 * size.y(), 0.5));
    }
  }

  void parkedRow(double x0, double x1, double y) {
    for (double x = x0 + 3.0; x < x1 - 3.0; x += random_.uniform(6.0, 9.0)) {
      if (random_.uniform() < 0.75) parked(x, y, random_.uniform() < 0.2 ? kVan : kCar);
    }
  }

 private:
  World::Parts& parts_;
  Random random_;
  bool turned_ = false;
};

void addActor(TrafficScene& scene, ActorKind kind, const Eigen::Vector3d& size, Points path,
              Speeds speeds) {
  scene.actors.push_back({static_cast<long>(scene.actors.size()) + 1,
                          kind,
                          size,
                          {std::move(path), std::move(speeds)}});
}

void addPedestrian(TrafficScene& scene, Points path, Speeds speeds) {
  addActor(scene, ActorKind::kPedestrian, kPerson, std::move(path), std::move(speeds));
}

void addVehicle(TrafficScene& scene, const Eigen::Vector3d& size, Points path, Speeds speeds) {
  addActor(scene, ActorKind::kVehicle, size, std::move(path), std::move(speeds));
}

/// From `in` around the corner to `out`: a path with a curve of this radius.
Points turnPath(const Eigen::Vector2d& in, const Eigen::Vector2d& corner,
                const Eigen::Vector2d& out, double radius) {
  Points path = {in};
  const Points curve = roundedCorner(corner + radius * (in - corner).normalized(), corner,
                                     corner + radius * (out - corner).normalized());
  path.insert(path.end(), curve.begin(), curve.end());
  path.push_back(out);
  return path;
}

void buildCrossing(World::Parts& parts) {
  StreetBuilder builder(parts, 7);
  for (const bool turned : {false, true}) {
    builder.turn(turned);
    for (const double side : {-1.0, 1.0}) {
      for (const double x : {-90.0, 13.0}) builder.houses(x, x + 77.0, side * 13.0);
    }
  }
  builder.turn(false);
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      builder.sidewalk(x * 7.0, x * 90.0, y * 7.0, y * 90.0);
      builder.pole(x * 7.6, y * 7.6, 0.1, 5.0);
      builder.pole(x * 9.0, y * 12.0, 0.3, 1.2);
    }
  }
  for (const bool turned : {false, true}) {
    builder.turn(turned);
    for (const double side : {-1.0, 1.0}) {
      builder.furniture(-80.0, -14.0, side * 8.0);
      builder.furniture(14.0, 80.0, side * 8.0);
    }
  }
  builder.turn(false);
  builder.parkedRow(24.0, 70.0, 6.0);
  builder.parkedRow(-70.0, -24.0, -6.0);
}

void addCrossingVehicles(TrafficScene& scene) {
  // The traffic light: east-west has green until 7 s, north-south from 8 s to 15 s.
  addVehicle(scene, kCar, {{-75, -2.2}, {75, -2.2}}, {{0, 11}});
  addVehicle(scene, kCar, {{-75, -2.2}, {75, -2.2}}, {{3, 10}, {7, 8}, {11, 0}, {16, 0}, {20, 7}});
  addVehicle(scene, kVan, {{75, 2.2}, {-75, 2.2}}, {{0, 10}});
  addVehicle(scene, kCar, {{75, 2.2}, {-75, 2.2}}, {{2.5, 12}});
  addVehicle(scene, kBus, {{75, 5.4}, {-75, 5.4}}, {{1, 9}, {4, 9}});
  // Turns right, from the west to the south.
  addVehicle(scene, kCar, turnPath({-75, -5.4}, {-2.6, -5.4}, {-2.6, -75}, 5.0),
             {{0.5, 11}, {5, 10}, {7.5, 5}, {10, 5}, {12, 9}});
  // Wait at the red light and start.
  addVehicle(scene, kCar, {{2.2, -12.0}, {2.2, 75}}, {{-1, 0}, {8, 0}, {12, 9}});
  addVehicle(scene, kCar, {{2.2, -19.0}, {2.2, 75}}, {{-1, 0}, {9, 0}, {13, 9}});
  addVehicle(scene, kVan, {{-2.2, 75}, {-2.2, -75}}, {{2, 10}, {5, 9}, {8, 6}, {10, 9}});
  // Turns left, from the north to the east.
  addVehicle(scene, kCar, turnPath({-5.4, 75}, {-5.4, -2.2}, {75, -2.2}, 7.0),
             {{4, 11}, {9, 9}, {11, 6}, {14, 6}, {16, 10}});
  // A parked car that starts.
  addVehicle(scene, kCar, {{14, -5.6}, {22, -5.6}, {28, -2.4}, {75, -2.2}},
             {{-1, 0}, {5, 0}, {9, 7}});
}

void addCrossingPedestrians(TrafficScene& scene) {
  addPedestrian(scene, {{9.0, -11}, {9.0, 11}}, {{7, 1.3}});
  addPedestrian(scene, {{10.2, -11.5}, {10.2, 11}}, {{7.2, 1.25}});
  addPedestrian(scene, {{-9.5, 11}, {-9.5, -11}}, {{8, 1.4}});
  addPedestrian(scene, {{-11.5, -9.5}, {12, -9.5}}, {{0, 1.2}});
  addPedestrian(scene, {{12, 9.8}, {-12, 9.8}}, {{0, 1.5}});
  // Stops in the middle and goes on.
  addPedestrian(scene, {{30, -10}, {5, -10}}, {{0, 1.4}, {6, 1.4}, {6.5, 0}, {11, 0}, {11.5, 1.4}});
  addPedestrian(scene, {{-30, 10}, {-10, 10}, {-10, 30}}, {{0, 1.6}});
  addActor(scene, ActorKind::kCyclist, kBicycle, {{60, 6.2}, {-70, 6.2}}, {{6, 5}});
}

void buildStreet(World::Parts& parts) {
  StreetBuilder builder(parts, 11);
  for (const double side : {-1.0, 1.0}) {
    builder.houses(-80.0, 88.0, side * 11.0);
    builder.houses(104.0, 300.0, side * 11.0);
    builder.sidewalk(-80.0, 90.0, side * 6.4, side * 11.0);
    builder.sidewalk(102.0, 300.0, side * 6.4, side * 11.0);
    builder.furniture(-70.0, 88.0, side * 7.2);
    builder.furniture(104.0, 290.0, side * 7.2);
    builder.parkedRow(-60.0, 84.0, side * 5.3);
    builder.parkedRow(108.0, 280.0, side * 5.3);
  }
  builder.turn(true);
  for (const double side : {-1.0, 1.0}) {
    for (const double from : {-80.0, 15.0}) {
      builder.houses(from, from + 65.0, side > 0.0 ? 104.0 : 0.0);
    }
  }
}

/// The houses of the side street on its near side.
void buildSideStreet(World::Parts& parts) {
  for (const double y : {-45.0, 45.0}) {
    parts.boxes.push_back({{85.0, y, 4.0}, {6.0, 60.0, 8.0}});
  }
}

void addStreetTraffic(TrafficScene& scene) {
  addVehicle(scene, kCar, {{120, 1.9}, {-70, 1.9}}, {{0, 9}});
  addVehicle(scene, kCar, {{160, 1.9}, {-70, 1.9}}, {{0, 9.5}});
  addVehicle(scene, kVan, {{230, 1.9}, {-70, 1.9}}, {{0, 8.5}});
  addVehicle(scene, kCar, {{290, 1.9}, {-70, 1.9}}, {{2, 9}});
  // Ahead in the same direction; it stops at the junction and drives on.
  addVehicle(scene, kCar, {{22, -1.9}, {290, -1.9}}, {{0, 8}, {6, 8}, {8.5, 2}, {10, 2}, {13, 9}});
  // Enters from the side street behind the vehicle ahead.
  addVehicle(scene, kCar, turnPath({94, -60}, {94, 1.9}, {-70, 1.9}, 6.0),
             {{2, 8}, {6, 7}, {8, 4.5}, {11, 8}});
  addVehicle(scene, kCar, {{98, 60}, {98, -60}}, {{11, 9}});
  // A parked car that starts.
  addVehicle(scene, kCar, {{136, -5.0}, {143, -4.6}, {150, -1.9}, {290, -1.9}},
             {{-1, 0}, {11, 0}, {15, 8}});
  addPedestrian(scene, {{5, -8.6}, {80, -8.6}}, {{0, 1.4}});
  addPedestrian(scene, {{60, -8.4}, {10, -8.4}}, {{0, 1.3}});
  addPedestrian(scene, {{70, 8.6}, {20, 8.6}}, {{0, 1.5}});
  addPedestrian(scene, {{71, 9.6}, {20, 9.6}}, {{0, 1.5}});
  addPedestrian(scene, {{104, -10}, {104, 10}}, {{9, 1.4}});
  addPedestrian(scene, {{120, 8.7}, {180, 8.7}}, {{4, 1.2}});
  addPedestrian(scene, {{170, -8.7}, {120, -8.7}}, {{6, 1.4}});
  addActor(scene, ActorKind::kCyclist, kBicycle, {{-20, -3.3}, {290, -3.3}}, {{0, 6}});
}

const LidarModel& lidarModel(const std::string& name) {
  return findByName(lidarModels(), "lidar", name);
}

}  // namespace

TrafficScene crossingScene() {
  TrafficScene scene;
  scene.name = "crossing";
  scene.lidar = lidarModel("hdl32e");
  scene.lidar_height_m = 1.9;
  scene.ego.path = {{0.0, 0.0}};
  buildCrossing(scene.still);
  addCrossingVehicles(scene);
  addCrossingPedestrians(scene);
  return scene;
}

TrafficScene streetScene() {
  TrafficScene scene;
  scene.name = "street";
  scene.lidar = lidarModel("hdl64e");
  scene.ego = {{{0.0, -1.9}, {60.0, -1.9}, {75.0, -1.5}, {90.0, -1.9}, {290.0, -1.9}},
               {{0.0, 7.0}, {6.0, 8.0}, {9.0, 5.0}, {11.0, 5.0}, {15.0, 9.0}}};
  scene.sway_rad = 0.006;
  buildStreet(scene.still);
  buildSideStreet(scene.still);
  addStreetTraffic(scene);
  return scene;
}

}  // namespace kestrel
