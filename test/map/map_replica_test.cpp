// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/map_replica.h"

#include <gtest/gtest.h>

#include "kestrel_slam/map/submap.h"
#include "room.h"

namespace kestrel {
namespace {

/// Takes all changes, `tiles` at a time. Returns the number of tiles.
std::size_t copyChanges(OccupancyGrid& grid, MapReplica& replica, std::size_t tiles = 7) {
  std::size_t count = 0;
  for (bool more = true; more;) {
    std::vector<TileImage> images;
    more = grid.takeChangedTiles(tiles, images);
    EXPECT_LE(images.size(), tiles);
    for (const TileImage& image : images) replica.update(image);
    count += images.size();
  }
  return count;
}

void expectEqual(const MapSnapshot& a, const MapSnapshot& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.origin_x, b.origin_x);
  EXPECT_EQ(a.origin_y, b.origin_y);
  EXPECT_EQ(a.cells, b.cells);
}

TEST(MapReplica, IsEqualToTheSnapshotAfterEveryCopy) {
  OccupancyGrid grid{OccupancyGridConfig()};
  MapReplica replica(0.05);
  for (int i = 0; i < 30; ++i) {
    const Pose2 pose(-0.2 * i, 0.1 * i, 0.05 * i);
    grid.insert(room::scanFrom(pose), pose);
    if (i % 4 == 0) copyChanges(grid, replica);
    if (i % 4 == 0) expectEqual(replica.snapshot(), grid.snapshot());
  }
  const std::size_t changed = copyChanges(grid, replica);
  EXPECT_GT(changed, 0U);
  EXPECT_EQ(copyChanges(grid, replica), 0U) << "nothing changed since";
  expectEqual(replica.snapshot(), grid.snapshot());
}

TEST(MapReplica, TheChangedPartIsAsSmallAsTheChange) {
  OccupancyGrid grid{OccupancyGridConfig()};
  MapReplica replica(0.05);
  grid.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(grid, replica);
  const CellRectangle first = replica.takeChanged(), known = replica.known();
  EXPECT_EQ(first.x1 - first.x0, known.x1 - known.x0);
  EXPECT_TRUE(replica.takeChanged().empty());
  PlanarScan beam;
  beam.rays.push_back({{10.0F, 10.0F}, {10.2F, 10.0F}, true});
  grid.insert(beam, Pose2());
  copyChanges(grid, replica);
  const CellRectangle second = replica.takeChanged();
  EXPECT_EQ(second.x1 - second.x0, 5);
  EXPECT_EQ(second.y1 - second.y0, 1);
  EXPECT_EQ(replica.valuesIn(second).back(), MapSnapshot::kOccupied);
}

TEST(MapReplica, ProbabilitiesAgreeWithTheStates) {
  OccupancyGrid grid{OccupancyGridConfig()};
  MapReplica replica(0.05);
  for (int i = 0; i < 12; ++i) grid.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(grid, replica);
  const MapSnapshot states = replica.snapshot(), percent = replica.probabilities();
  ASSERT_EQ(percent.cells.size(), states.cells.size());
  int high = 0, low = 0;
  for (std::size_t i = 0; i < states.cells.size(); ++i) {
    const int p = percent.cells[i];
    ASSERT_EQ(p < 0, states.cells[i] == MapSnapshot::kUnknown);
    if (p < 0) continue;
    ASSERT_EQ(p > 50, states.cells[i] == MapSnapshot::kOccupied) << p;
    ASSERT_LE(p, 100);
    high += p > 90;
    low += p < 10;
  }
  EXPECT_GT(high, 100) << "walls that were seen often";
  EXPECT_GT(low, 1000) << "free space that was seen often";
}

TEST(MapReplica, AMoreCertainCellIsNoChange) {
  OccupancyGrid grid{OccupancyGridConfig()};
  MapReplica replica(0.05);
  grid.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(grid, replica);
  replica.takeChanged();
  grid.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(grid, replica);
  EXPECT_TRUE(replica.takeChanged().empty());
}

/// A grid with a room, and one with the same room and a beam outside of it.
class AnotherMap : public testing::Test {
 protected:
  AnotherMap() {
    for (OccupancyGrid* grid : {&room_, &with_beam_})
      grid->insert(room::scanFrom(Pose2()), Pose2());
    PlanarScan beam;
    beam.rays.push_back({{10.0F, 10.0F}, {10.2F, 10.0F}, true});
    with_beam_.insert(beam, Pose2());
  }

  OccupancyGrid room_{OccupancyGridConfig()}, with_beam_{OccupancyGridConfig()};
  MapReplica replica_{0.05};
};

TEST_F(AnotherMap, OnlyWhatIsDifferentIsAChange) {
  copyChanges(room_, replica_);
  replica_.takeChanged();
  replica_.beginMap();
  copyChanges(with_beam_, replica_);
  replica_.endMap();
  expectEqual(replica_.snapshot(), with_beam_.snapshot());
  const CellRectangle changed = replica_.takeChanged();
  EXPECT_EQ(changed.x1 - changed.x0, 5);
  EXPECT_EQ(changed.y1 - changed.y0, 1);
}

TEST_F(AnotherMap, WhatItDoesNotHaveIsUnknown) {
  copyChanges(with_beam_, replica_);
  replica_.takeChanged();
  replica_.beginMap();
  copyChanges(room_, replica_);
  replica_.endMap();
  expectEqual(replica_.snapshot(), room_.snapshot());
  const CellRectangle changed = replica_.takeChanged();
  EXPECT_EQ(changed.x1 - changed.x0, 5);
  EXPECT_EQ(replica_.valuesIn(changed), std::vector<std::int8_t>(5, MapSnapshot::kUnknown));
}

TEST_F(AnotherMap, MayBeginAgainBeforeItIsComplete) {
  copyChanges(room_, replica_);
  replica_.takeChanged();
  replica_.beginMap();
  std::vector<TileImage> some;
  with_beam_.takeChangedTiles(2, some);
  for (const TileImage& image : some) replica_.update(image);
  replica_.beginMap();
  OccupancyGrid same{OccupancyGridConfig()};
  same.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(same, replica_);
  replica_.endMap();
  expectEqual(replica_.snapshot(), room_.snapshot());
  EXPECT_TRUE(replica_.takeChanged().empty());
}

TEST_F(AnotherMap, MayBeEmpty) {
  copyChanges(room_, replica_);
  replica_.takeChanged();
  replica_.beginMap();
  replica_.endMap();
  EXPECT_TRUE(replica_.snapshot().empty());
  EXPECT_TRUE(replica_.known().empty());
  EXPECT_FALSE(replica_.takeChanged().empty());
}

}  // namespace
}  // namespace kestrel
