#include "kestrel_slam/map/submap.h"

#include <gtest/gtest.h>

#include "room.h"

namespace kestrel_slam {
namespace {

constexpr double kLimitMb = 1.0;
constexpr std::size_t kLimitBytes = 1000000;

OccupancyGridConfig smallConfig() {
  OccupancyGridConfig config;
  config.memory_limit_mb = kLimitMb;
  return config;
}

/// Walks away along x through one room after the other; the number of scans that did not fit.
int walk(Submap& map, int scans) {
  int full = 0;
  for (int i = 0; i < scans; ++i) {
    full += map.insert(room::scanFrom(Pose2()), Pose2(1.0 * i, 0.3, 0.1)) ? 0 : 1;
  }
  return full;
}

TEST(Submap, CountsScansAndForgetsThem) {
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
  EXPECT_EQ(walk(map, 1), 0) << "usable again";
}

TEST(Submap, SaysSoWhereGridOrSurfaceIsFull) {
  Submap map{smallConfig()};
  EXPECT_GT(walk(map, 60), 0);
}

TEST(Submap, WhatWasInsertedWhollyCanBeMatched) {
  Submap map{smallConfig()};
  int whole = 0, checked = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose2 pose(1.0 * i, 0.3, 0.1);
    const PlanarScan scan = room::scanFrom(Pose2());
    if (!map.insert(scan, pose)) continue;
    ++whole;
    for (const Eigen::Vector2f& point : room::hitsOf(scan)) {
      const Eigen::Vector2f in_map = (pose * point.cast<double>()).cast<float>();
      if (!map.grid().isOccupied(map.grid().cellAt(in_map))) continue;  // seen free too often
      ++checked;
      ASSERT_NE(map.surface().nearest(in_map), nullptr) << "scan " << i;
    }
  }
  EXPECT_GT(whole, 3);
  EXPECT_GT(checked, 1000);
}

TEST(Submap, FullMapStopsGrowing) {
  Submap map{smallConfig()};
  walk(map, 200);
  const std::size_t surfels = map.surface().size(), bytes = map.memoryBytes();
  for (int i = 0; i < 5; ++i) walk(map, 200);
  EXPECT_LE(map.surface().size(), surfels + surfels / 10);  // cells still come and go
  EXPECT_LE(map.memoryBytes(), bytes + bytes / 10);
  EXPECT_LE(map.grid().memoryBytes(), kLimitBytes);
  EXPECT_LE(map.surface().memoryBytes(), 2 * kLimitBytes);
}

}  // namespace
}  // namespace kestrel_slam
