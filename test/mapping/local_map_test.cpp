// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/local_map.h"

#include <gtest/gtest.h>

#include "room.h"

namespace kestrel {
namespace {

WindowConfig windowOf(int scans, int overlap) {
  WindowConfig window;
  window.enabled = true;
  window.submap_scans = scans;
  window.overlap_scans = overlap;
  return window;
}

void insertAt(double x, LocalMap& map, bool degenerate = false) {
  map.insert(room::scanFrom(Pose2(x, 0, 0), room::corridor()), Pose2(x, 0, 0), false, degenerate);
}

bool knows(const LocalMap& map, double x) {
  const OccupancyGrid& grid = map.current().grid();
  return grid.isKnown(grid.cellAt({static_cast<float>(x), 0.0F}));
}

TEST(LocalMap, WithoutAWindowThereIsOneSubmap) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), WindowConfig()};
  for (int i = 0; i < 300; ++i) insertAt(0.25 * i, map);
  EXPECT_EQ(map.submap(), 0U);
  EXPECT_TRUE(knows(map, 0.0));
}

TEST(LocalMap, TheWindowForgetsWhatIsBeforeTheOverlap) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), windowOf(60, 20)};
  for (int i = 0; i < 61; ++i) insertAt(0.25 * i, map);
  EXPECT_EQ(map.submap(), 1U);
  EXPECT_FALSE(knows(map, -5.0)) << "only the scans 40 to 60 are in the window";
  EXPECT_TRUE(knows(map, 0.25 * 40));
}

TEST(LocalMap, ASubmapInACorridorIsLonger) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), windowOf(60, 20)};
  for (int i = 0; i < 61; ++i) insertAt(0.25 * i, map, true);
  EXPECT_EQ(map.submap(), 0U);
}

TEST(LocalMap, KnowsWhichLasersItLacks) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), WindowConfig()};
  PlanarScan scan = room::scanFrom(Pose2(), room::corridor());
  scan.source = "left";
  EXPECT_TRUE(map.lacks("left"));
  map.insert(scan, Pose2(), false, false);
  EXPECT_FALSE(map.lacks("left"));
  EXPECT_TRUE(map.lacks("right"));
}

TEST(LocalMap, ScansThatAreFarApartCountMore) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), windowOf(60, 20)};
  for (int i = 0; i < 40; ++i) insertAt(1.0 * i, map);
  EXPECT_EQ(map.submap(), 1U);
}

/// A vehicle that was carried by its odometry may be far away when a scan is inserted again.
TEST(LocalMap, AStepLongerThanASubmapKeepsTheWindow) {
  LocalMap map{OccupancyGridConfig(), SubmapOptions(), windowOf(60, 20)};
  insertAt(0.0, map);
  insertAt(500.0, map);
  insertAt(500.5, map);
  insertAt(501.0, map);
  EXPECT_EQ(map.submap(), 1U);
  EXPECT_TRUE(knows(map, 500.5));
}

}  // namespace
}  // namespace kestrel
