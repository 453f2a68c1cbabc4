// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/wall_agreement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../src/graph/wall_comparison.h"
#include "loop_world.h"

namespace kestrel {
namespace {

constexpr std::size_t kAllBeams = 100000;

WallAgreement compare(const Submap& map, const PlanarScan& scan, const Pose2& pose) {
  return compareWalls(map, {{pose, &scan}}, kAllBeams);
}

WallAgreement compareBetweenEnds(const Submap& map, const PlanarScan& scan, const Pose2& pose) {
  return compareWalls(map, {{pose, &scan}}, kAllBeams, CrossedWalls::kBetweenEnds);
}

/// A wall of 3 m in front of the right wall of the room, with a door in the middle or without.
Submap mapWithWall(bool open) {
  std::vector<room::Segment> walls = room::walls();
  const double half = open ? 0.5 : 0.0;
  walls.push_back({2.0, -1.5, 2.0, -half});
  walls.push_back({2.0, half, 2.0, 1.5});
  Submap map{OccupancyGridConfig()};
  for (const Pose2& pose : {Pose2(1.5, 0.2, 0), Pose2(0.5, 0.8, 1), Pose2(-0.6, -0.4, 2)})
    map.insert(room::scanFrom(pose, walls), pose);
  for (const Pose2& pose : {Pose2(3.2, 0.2, 0), Pose2(3.0, -1.0, 1)})
    map.insert(room::scanFrom(pose, walls), pose);
  return map;
}

TEST(WallAgreement, TheOwnPlaceAgrees) {
  const Pose2 pose(1, -1, 2.1);
  const WallAgreement walls = compare(room::map(), room::scanFrom(pose), pose);
  EXPECT_GT(walls.hits, 150U);
  EXPECT_LT(walls.contradiction(), 0.02);
  EXPECT_GT(walls.score(), 0.97);
}

TEST(WallAgreement, WallsOfOnlyTheScanOrOnlyTheMapContradict) {
  const Pose2 pose(1, -1, 2.1);
  const PlanarScan scan = room::scanFrom(pose);
  const WallAgreement turned = compare(room::map(), scan, pose * Pose2(0, 0, 1.5));
  EXPECT_GT(turned.contradiction(), 0.4);
  EXPECT_GT(turned.crossed, 30U);
  EXPECT_LT(turned.matched, turned.known / 2);
}

/// The door was closed in the map. Most beams pass through it, but it is short.
TEST(WallAgreement, AnOpenDoorIsAMeterOfWall) {
  std::vector<room::Segment> open = room::walls();
  open.push_back({2.0, -1.5, 2.0, -0.5});
  open.push_back({2.0, 0.5, 2.0, 1.5});
  const Pose2 pose(1.7, 0, 0);
  const WallAgreement walls = compare(mapWithWall(false), room::scanFrom(pose, open), pose);
  EXPECT_NEAR(0.1 * static_cast<double>(walls.crossed), 1.0, 0.3);
  EXPECT_LT(walls.contradiction(), 0.1);
  const WallAgreement inner =
      compareBetweenEnds(mapWithWall(false), room::scanFrom(pose, open), pose);
  EXPECT_NEAR(0.1 * static_cast<double>(inner.crossed), 1.0, 0.3);
}

/// The legs of chairs stood elsewhere, and all of them are gone. The beams pass where they were.
TEST(WallAgreement, ThinThingsAreNotCrossed) {
  const Pose2 pose(-0.5, 0.6, 0.3);
  std::vector<room::Segment> chairs = room::walls();
  for (const double x : {-2.0, -1.2, 0.3, 1.1})
    for (const double y : {-1.5, -0.9, 0.2, 1.7}) loop_world::addBox(chairs, x, y, 0.04, 0.04);
  Submap map{OccupancyGridConfig()};
  for (const Pose2& at : {Pose2(0, 0, 0), Pose2(0.5, 0.6, 1), Pose2(-0.6, -0.4, 2)})
    map.insert(room::scanFrom(at, chairs, 1440), at);
  const PlanarScan scan = room::scanFrom(pose, room::walls(), 1440);
  const WallAgreement walls = compareBetweenEnds(map, scan, pose);
  EXPECT_LT(walls.crossed, 4U);
  EXPECT_LT(walls.contradiction(), 0.03);
}

/// A beam passes beside the end of a wall by less than a cell. A slightly different pose hits it.
TEST(WallAgreement, TheEndOfAWallIsNotCrossed) {
  std::vector<room::Segment> longer = room::walls(), shorter = room::walls();
  longer.push_back({1.0, -2.0, 1.0, 0.08});
  shorter.push_back({1.0, -2.0, 1.0, 0.0});
  Submap map{OccupancyGridConfig()};
  for (const Pose2& at : {Pose2(0, 0, 0), Pose2(0.3, 0.6, 1), Pose2(-0.6, -0.4, 2)})
    map.insert(room::scanFrom(at, longer, 1440), at);
  const Pose2 pose(-0.5, 0.05, 0);
  const PlanarScan scan = room::scanFrom(pose, shorter, 1440);
  EXPECT_EQ(compareBetweenEnds(map, scan, pose).crossed, 0U);
  EXPECT_GT(compare(map, scan, pose).crossed, 0U);
}

TEST(WallAgreement, UnknownSpaceIsNoContradiction) {
  Submap map{OccupancyGridConfig()};
  PlanarScan half = room::scanFrom(Pose2(-1, 0.5, 0));
  half.rays.resize(half.rays.size() / 2);
  map.insert(half, Pose2(-1, 0.5, 0));
  const WallAgreement walls = compare(map, room::scanFrom(Pose2(-1, 0.5, 0)), Pose2(-1, 0.5, 0));
  EXPECT_LT(walls.known, walls.hits * 7 / 10);
  EXPECT_LT(walls.contradiction(), 0.05);
  EXPECT_LT(walls.score(), 0.8);
}

TEST(WallAgreement, FewWallsAreLessCertain) {
  WallAgreement few{40, 40, 36, 0}, many{160, 160, 144, 0};
  EXPECT_DOUBLE_EQ(few.score(), many.score());
  EXPECT_NEAR(few.variance(), 4.0 * many.variance(), 1e-12);
  EXPECT_GT(few.possibleContradiction(), many.possibleContradiction());
  EXPECT_GT(many.possibleContradiction(), many.contradiction());
  EXPECT_GT(few.contradictionBound(), many.contradictionBound());
  EXPECT_GT(many.contradictionBound(), many.possibleContradiction());
  const WallAgreement all_fit{40, 40, 40, 0};
  EXPECT_NEAR(all_fit.contradictionBound(), 4.0 / (8.0 + 4.0), 1e-6) << "8 pieces of wall";
  EXPECT_EQ(WallAgreement().score(), 0.0);
  EXPECT_EQ(WallAgreement().contradiction(), 0.0);
}

}  // namespace
}  // namespace kestrel
