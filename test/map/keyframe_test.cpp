// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/keyframe.h"

#include <gtest/gtest.h>

#include "kestrel_slam/map/occupancy_grid.h"
#include "map/scans_of_lasers.h"

namespace kestrel {
namespace {

TEST(Keyframe, GivesBackTheScan) {
  Keyframe keyframe;
  keyframe.stamp = 3.5;
  keyframe.time = 3.6;
  keyframe.scan = CompactScan({{{0.5F, 0.0F}, {2.0F, 1.0F}, true}});
  const PlanarScan scan = keyframe.planarScan();
  EXPECT_EQ(scan.stamp, 3.5);
  EXPECT_EQ(scan.time, 3.6);
  ASSERT_EQ(scan.rays.size(), 1U);
  EXPECT_EQ(scan.rays[0].end, Eigen::Vector2f(2.0F, 1.0F));
  EXPECT_EQ(scan.rays[0].origin, Eigen::Vector2f(0.5F, 0.0F));
  EXPECT_EQ(keyframe.memoryBytes(), sizeof(Keyframe) + keyframe.scan.bytes().capacity());
}

/// Share of the known cells of `a` that have another state in `b`. Both maps cover the same area.
double differenceOf(const MapSnapshot& a, const MapSnapshot& b) {
  EXPECT_EQ(a.cells.size(), b.cells.size());
  double known = 0.0, different = 0.0;
  for (std::size_t i = 0; i < std::min(a.cells.size(), b.cells.size()); ++i) {
    known += a.cells[i] != MapSnapshot::kUnknown ? 1.0 : 0.0;
    different += a.cells[i] != b.cells[i] ? 1.0 : 0.0;
  }
  return different / known;
}

TEST(Keyframe, AMapFromKeyframesIsNearlyTheMapFromTheScans) {
  // A beam of 60 m that ends 1 mm away passes some other cells.
  constexpr double kMaxDifference = 0.02;
  for (const LaserScans& laser : scansOfLasers()) {
    if (laser.poses.empty()) continue;
    OccupancyGrid original{OccupancyGridConfig()}, again{OccupancyGridConfig()};
    for (std::size_t i = 0; i < laser.scans.size(); ++i) {
      original.insert(laser.scans[i], laser.poses[i]);
      Keyframe keyframe;
      keyframe.scan = CompactScan(laser.scans[i].rays);
      again.insert(keyframe.planarScan(), laser.poses[i]);
    }
    const double difference = differenceOf(original.snapshot(), again.snapshot());
    EXPECT_LE(difference, kMaxDifference) << laser.name;
  }
}

}  // namespace
}  // namespace kestrel
