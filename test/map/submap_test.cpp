// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/submap.h"

#include <gtest/gtest.h>

#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kLimitMb = 1.0;
constexpr std::size_t kLimitBytes = 1000000;

OccupancyGridConfig smallConfig() {
  OccupancyGridConfig config;
  config.memory_limit_mb = kLimitMb;
  return config;
}

/// Inserts scans of one room after the other along x. Returns the number of scans that did not fit.
int walk(Submap& map, int scans) {
  int full = 0;
  for (int i = 0; i < scans; ++i) {
    full += map.insert(room::scanFrom(Pose2()), Pose2(1.0 * i, 0.3, 0.1)) ? 0 : 1;
  }
  return full;
}

TEST(Submap, CountsScansAndClears) {
  Submap map{OccupancyGridConfig()};
  EXPECT_EQ(walk(map, 3), 0);
  EXPECT_EQ(map.scans(), 3);
  EXPECT_GT(map.surface().size(), 100U);
  EXPECT_EQ(map.memoryBytes(), map.grid().memoryBytes() + map.surface().memoryBytes());
  map.clear();
  EXPECT_EQ(map.scans(), 0);
  EXPECT_EQ(map.surface().size(), 0U);
  EXPECT_EQ(map.surface().nearest({4.0F, 0.0F}), nullptr);
  EXPECT_TRUE(map.grid().snapshot().empty());
  EXPECT_EQ(walk(map, 1), 0) << "must be usable again";
}

TEST(Submap, ReportsThatGridOrSurfaceIsFull) {
  Submap map{smallConfig()};
  EXPECT_GT(walk(map, 60), 0);
}

TEST(Submap, OneMemoryLimitHoldsForAllPartsAndFullIsRemembered) {
  Submap map{smallConfig()};
  EXPECT_FALSE(map.isFull());
  walk(map, 60);
  EXPECT_TRUE(map.isFull());
  EXPECT_LE(map.memoryBytes(), kLimitBytes);
  EXPECT_GT(map.memoryBytes(), kLimitBytes / 2);
  PlanarScan nothing;
  EXPECT_TRUE(map.insert(nothing, Pose2()));
  EXPECT_TRUE(map.isFull()) << "a complete insertion does not make the map complete";
  map.clear();
  EXPECT_FALSE(map.isFull());
  EXPECT_EQ(walk(map, 1), 0) << "the memory was given back";
}

TEST(Submap, EveryHitOfACompleteInsertionHasASurfel) {
  Submap map{smallConfig()};
  int complete = 0, checked = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose2 pose(1.0 * i, 0.3, 0.1);
    const PlanarScan scan = room::scanFrom(Pose2());
    if (!map.insert(scan, pose)) continue;
    ++complete;
    for (const Eigen::Vector2f& point : hitsOf(scan)) {
      const Eigen::Vector2f in_map = (pose * point.cast<double>()).cast<float>();
      if (!map.grid().isOccupied(map.grid().cellAt(in_map))) continue;  // established as free
      ++checked;
      ASSERT_NE(map.surface().nearest(in_map), nullptr) << "scan " << i;
    }
  }
  EXPECT_GT(complete, 3);
  EXPECT_GT(checked, 1000);
}

TEST(Submap, AFullMapStopsGrowing) {
  Submap map{smallConfig()};
  walk(map, 200);
  const std::size_t surfels = map.surface().size(), bytes = map.memoryBytes();
  for (int i = 0; i < 5; ++i) walk(map, 200);
  EXPECT_LE(map.surface().size(), surfels + surfels / 10);  // cells are still created and removed
  EXPECT_LE(map.memoryBytes(), bytes + bytes / 10);
  EXPECT_LE(map.grid().memoryBytes(), kLimitBytes);
  EXPECT_LE(map.surface().memoryBytes(), 5 * kLimitBytes / 2);  // tiles and surfels
}

TEST(Submap, RevisionIdentifiesTheContent) {
  Submap a{OccupancyGridConfig()}, b{OccupancyGridConfig()};
  EXPECT_NE(a.revision(), b.revision());
  const std::uint64_t empty = a.revision();
  walk(a, 1);
  EXPECT_NE(a.revision(), empty);
  EXPECT_NE(a.revision(), b.revision());
  const std::uint64_t full = a.revision();
  a.clear();
  EXPECT_NE(a.revision(), full);
}

TEST(Submap, KeepsTheLastScans) {
  Submap map(OccupancyGridConfig(), {3, false});
  EXPECT_EQ(walk(map, 2), 0);
  EXPECT_EQ(map.keyframes().size(), 2U);
  EXPECT_EQ(walk(map, 10), 0);
  ASSERT_EQ(map.keyframes().size(), 3U);
  EXPECT_EQ(map.keyframes().front().map_T_base, Pose2(7.0, 0.3, 0.1)) << "oldest first";
  EXPECT_EQ(map.keyframes().back().map_T_base, Pose2(9.0, 0.3, 0.1));
  EXPECT_EQ(map.keyframes().back().hits, hitsOf(room::scanFrom(Pose2())));
  EXPECT_GT(map.memoryBytes(), map.grid().memoryBytes() + map.surface().memoryBytes());
  map.clear();
  EXPECT_TRUE(map.keyframes().empty());
}

/// A scan of the wall x = `range` with `beams` hits, 5 cm apart.
PlanarScan wallAt(float range, int beams) {
  PlanarScan scan;
  for (int i = 0; i < beams; ++i) {
    const float y = 0.05F * static_cast<float>(i);
    scan.rays.push_back({{0.0F, y}, {range, y}, true});
  }
  return scan;
}

TEST(Submap, StitchesOnlyTheNewPart) {
  const Pose2 pose(0.025, 0.025, 0.0);
  Submap plain{OccupancyGridConfig()}, stitched(OccupancyGridConfig(), {0, true});
  for (Submap* map : {&plain, &stitched}) {
    map->insert(wallAt(2.0F, 10), pose);
    EXPECT_EQ(map->surface().size(), 10U) << "all hits are new in an empty map";
  }
  const double once = stitched.grid().probability({40, 5});
  ASSERT_EQ(once, plain.grid().probability({40, 5}));
  // 1 cm farther and twice as long: the first half is associated, the second half is new.
  for (Submap* map : {&plain, &stitched}) map->insert(wallAt(2.01F, 20), pose);
  for (int y = 0; y < 20; ++y) {
    const Cell cell{40, y};
    EXPECT_EQ(stitched.grid().probability(cell), once) << y;
    const Surfel* surfel = stitched.surface().nearest(stitched.grid().centerOf(cell));
    ASSERT_NE(surfel, nullptr);
    // The first cell after the end of the old wall is next to its last point, so it is associated.
    EXPECT_NEAR(surfel->mean.x(), y < 10 ? 2.025F : 2.035F, 1e-4F) << y;
    EXPECT_GE(plain.grid().probability(cell), once);
  }
  EXPECT_GT(plain.grid().probability({40, 5}), once) << "without stitching every hit counts again";
  // Free space is updated by every scan.
  EXPECT_LT(stitched.grid().probability({20, 5}), 0.4);
}

TEST(Submap, ClearsAStitchedWallOnlyIfItIsGone) {
  const Pose2 pose(0.025, 0.025, 0.0);
  Submap map(OccupancyGridConfig(), {0, true});
  map.insert(wallAt(2.0F, 10), pose);
  // Seen again many times, sometimes with an end point behind its cell.
  for (int i = 0; i < 100; ++i)
    map.insert(wallAt(2.0F + 0.04F * static_cast<float>(i % 2), 10), pose);
  EXPECT_EQ(map.surface().size(), 10U);
  EXPECT_TRUE(map.grid().isOccupied({40, 5}));
  for (int i = 0; i < 10; ++i) map.insert(wallAt(3.0F, 10), pose);
  EXPECT_FALSE(map.grid().isOccupied({40, 5}));
  EXPECT_TRUE(map.grid().isOccupied({60, 5}));
}

}  // namespace
}  // namespace kestrel
