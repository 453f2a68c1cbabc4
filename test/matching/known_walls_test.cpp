// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/matching/known_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "room.h"

namespace kestrel {
namespace {

/// A wall along y = 1 m from x = 0 to 3 m with a return of 0.3 m at its left end, seen from inside
/// of the corner at (1, 0).
Submap cornerMap() {
  Submap map{OccupancyGridConfig()};
  const std::vector<room::Segment> walls = {{0.0, 1.0, 3.0, 1.0}, {0.0, 0.7, 0.0, 1.0}};
  for (int i = 0; i < 3; ++i) {
    PlanarScan scan = room::scanFrom(Pose2(1, 0, 0), walls, 720);
    scan.rays.erase(std::remove_if(scan.rays.begin(), scan.rays.end(),
                                   [](const PlanarRay& ray) { return !ray.hit; }),
                    scan.rays.end());
    map.insert(scan, Pose2(1, 0, 0));
  }
  return map;
}

/// Whether a hit at (x, y) of a vehicle at `pose` is one of a known wall. The next hit is
/// `spacing_m` farther.
bool isOfKnownWall(const Submap& map, const Pose2& pose, double x, double y,
                   double spacing_m = 0.01) {
  const Eigen::Vector2f hit = (pose.inverse() * Eigen::Vector2d(x, y)).cast<float>();
  const Eigen::Vector2f next = hit * (1.0F + static_cast<float>(spacing_m) / hit.norm());
  const Points found = hitsOfKnownWalls(map, {hit, next}, pose, 2);
  return !found.empty() && found.front() == hit;
}

TEST(KnownWalls, HitsOnAWallAndBehindItCount) {
  const Submap map = cornerMap();
  EXPECT_TRUE(isOfKnownWall(map, Pose2(1, 0, 0), 1.5, 1.0));
  EXPECT_TRUE(isOfKnownWall(map, Pose2(1, 0, 0), 1.5, 1.3));
  // At a small angle the beam crosses the wall far before its end.
  EXPECT_TRUE(isOfKnownWall(map, Pose2(1, 0, 0), 2.8, 1.2));
}

TEST(KnownWalls, AHitInFreeSpaceContradictsThemAndCounts) {
  EXPECT_TRUE(isOfKnownWall(cornerMap(), Pose2(1, 0, 0), 1.2, 0.6));
}

TEST(KnownWalls, AHitPastTheEndOfAWallIsNew) {
  const Submap map = cornerMap();
  EXPECT_FALSE(isOfKnownWall(map, Pose2(3, 0, 0), 3.3, 1.0));
}

TEST(KnownWalls, TheHitsOfADistantWallAreFarApart) {
  EXPECT_TRUE(isOfKnownWall(cornerMap(), Pose2(3, 0, 0), 3.3, 1.0, 0.4));
}

TEST(KnownWalls, AHitBesideTheEndOfAWallIsNew) {
  const Submap map = cornerMap();
  // The wall of the return is 0.2 m away, across it, but the beam does not cross it.
  EXPECT_FALSE(isOfKnownWall(map, Pose2(-0.3, 0, 0), -0.2, 0.85));
}

TEST(KnownWalls, FarFromAllWallsUnknownSpaceIsNew) {
  EXPECT_FALSE(isOfKnownWall(cornerMap(), Pose2(1, 0, 0), 9.0, 5.0));
}

}  // namespace
}  // namespace kestrel
