// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <limits>
#include <string>

#include "built_in_places.h"
#include "kestrel_slam/geometry/random.h"
#include "place_parts.h"

namespace kestrel {
namespace {

constexpr double kLaserHeight = 1.0;  // m
/// Distance of buildings, trees and cars from the middle of the crossings, m.
constexpr double kCrossing = 12.0;

/// What stands along the roads.
struct Roadside {
  double narrowest_gap_m = 3.0, widest_gap_m = 16.0;  ///< between two houses
  double tree_share = 0.3, car_share = 0.45;          ///< of all slots of 6 m
};

/// Adds a row of houses with gaps between them. Their fronts are not exactly aligned.
void addHouses(World::Parts& parts, const WallLine& road, double offset, const Roadside& roadside,
               Random& random) {
  constexpr double kShortest = 12.0, kLongest = 34.0, kDeepest = 18.0, kLeastDepth = 9.0;  // m
  constexpr double kSetback = 4.0, kTallest = 15.0, kLeastTall = 5.0;
  const double side = offset > 0.0 ? 1.0 : -1.0;
  for (double at = kCrossing; at < road.length() - kCrossing;) {
    const double length = random.uniform(kShortest, kLongest);
    const double depth = random.uniform(kLeastDepth, kDeepest);
    const double front = offset + side * random.uniform(0.0, kSetback);
    addBlock(parts, road.at(at + 0.5 * length, front + side * 0.5 * depth),
             {length, depth, random.uniform(kLeastTall, kTallest)}, road.yaw());
    // A porch or a staircase in front of the house.
    addBlock(parts, road.at(at + random.uniform(0.2, 0.8) * length, front - side * 0.5),
             {random.uniform(1.5, 3.0), 1.0, 2.8}, road.yaw());
    at += length + random.uniform(roadside.narrowest_gap_m, roadside.widest_gap_m);
  }
}

/// Adds a row of trees with parked cars between them.
void addTreesAndCars(World::Parts& parts, const WallLine& road, double offset,
                     const Roadside& roadside, Random& random) {
  constexpr double kSlot = 6.0;  // m
  const double side = offset > 0.0 ? 1.0 : -1.0;
  for (double at = kCrossing; at < road.length() - kCrossing; at += kSlot) {
    const double kind = random.uniform(), along = at + random.uniform(0.0, 1.2);
    if (kind < roadside.tree_share) {
      addPole(parts, road.at(along, offset + side * random.uniform(1.0, 2.0)),
              random.uniform(0.12, 0.35), 5.0);
    } else if (kind < roadside.tree_share + roadside.car_share) {
      addBlock(parts, road.at(along, offset + random.uniform(-0.2, 0.2)),
               {random.uniform(3.6, 4.8), random.uniform(1.6, 1.9), random.uniform(1.4, 2.0)},
               road.yaw() + random.uniform(-0.03, 0.03));
    }
  }
}

/// Adds a park with trees and sheds in the middle.
void addPark(World::Parts& parts, Random& random) {
  constexpr int kTrees = 150, kSheds = 12;
  constexpr double kHalf = 105.0;  // m, half of its width
  const auto somewhere = [&] {
    return Eigen::Vector2d(random.uniform(-kHalf, kHalf), random.uniform(-kHalf, kHalf));
  };
  for (int i = 0; i < kTrees; ++i) addPole(parts, somewhere(), random.uniform(0.1, 0.4), 6.0);
  for (int i = 0; i < kSheds; ++i) {
    const Eigen::Vector2d center = somewhere();
    addBlock(parts, center, {random.uniform(4.0, 12.0), random.uniform(3.0, 8.0), 4.0},
             random.uniform(0.0, 3.0));
  }
}

/// `half_width`: half the side length of the square formed by the center line of the road, m.
Place townOf(const std::string& name, const std::string& description, double half_width,
             const Roadside& roadside = Roadside()) {
  constexpr double kInnerFront = 12.0, kOuterFront = -13.0;  // m from the middle of the road
  constexpr double kInnerCars = 4.5, kOuterCars = -4.5;
  constexpr double kSpacing = 8.0;  // m between waypoints; about the radius of the curves
  constexpr std::uint64_t kSeed = 2;
  Place town;
  town.name = name;
  town.description = description;
  town.parts.ceiling_m = std::numeric_limits<double>::infinity();
  Random random(kSeed);
  const double c = half_width, z = kLaserHeight;
  const std::vector<Eigen::Vector2d> corners = {{-c, -c}, {c, -c}, {c, c}, {-c, c}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const WallLine road = {corners[i], corners[(i + 1) % corners.size()]};
    addHouses(town.parts, road, kInnerFront, roadside, random);
    addHouses(town.parts, road, kOuterFront, roadside, random);
    addTreesAndCars(town.parts, road, kInnerCars, roadside, random);
    addTreesAndCars(town.parts, road, kOuterCars, roadside, random);
  }
  addPark(town.parts, random);
  town.plan.waypoints =
      aroundLoop({{0, -c, z}, {c, -c, z}, {c, c, z}, {-c, c, z}, {-c, -c, z}}, kSpacing);
  town.plan.speed_m_s = 4.0;
  town.plan.acceleration_m_s2 = 1.0;
  town.plan.nose_forward = true;
  return town;
}

}  // namespace

Place town() {
  return townOf(
      "town",
      "roads around a block of 300 m x 300 m with houses, trees and parked cars, one loop of "
      "1.2 km at 4 m/s",
      150.0);
}

Place sparseTown() {
  constexpr double kGap = 50.0, kTreeShare = 0.03, kCarShare = 0.03;
  return townOf(
      "sparse_town",
      "as town, but around 360 m x 360 m, with gaps of 50 m between the houses, few trees "
      "and few cars",
      180.0, {kGap, kGap, kTreeShare, kCarShare});
}

Place largeTown() {
  return townOf("large_town", "as town, but around 600 m x 600 m, one loop of 2.4 km", 300.0);
}

}  // namespace kestrel
