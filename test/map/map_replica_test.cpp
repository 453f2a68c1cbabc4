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

TEST(MapReplica, IsEmptyAfterClear) {
  OccupancyGrid grid{OccupancyGridConfig()};
  MapReplica replica(0.05);
  grid.insert(room::scanFrom(Pose2()), Pose2());
  copyChanges(grid, replica);
  replica.clear();
  EXPECT_TRUE(replica.snapshot().empty());
  EXPECT_TRUE(replica.known().empty() && replica.takeChanged().empty());
  grid.clear();
  EXPECT_EQ(copyChanges(grid, replica), 0U);
}

}  // namespace
}  // namespace kestrel
