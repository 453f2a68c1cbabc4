// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/simulation/sensor_models.h"
#include "simulation/steady_motion.h"

namespace kestrel {
namespace {

TEST(LidarModel, PointsLieOnWallFloorAndCeiling) {
  LidarModel lidar = lidarModels().front();
  lidar.errors = BeamErrors();
  Random random(1);
  const PointCloud cloud = sweep(lidar, wallAt(5.0), SteadyMotion(), kNoOffset, 7.0, random);
  EXPECT_EQ(cloud.stamp, 7.0);
  ASSERT_EQ(cloud.points.size(), 16u * 1800u);
  int wall = 0, floor = 0, ceiling = 0, none = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const PointCloud::Point& point = cloud.points[i];
    EXPECT_NEAR(point.time, static_cast<double>(i / 16) / 18000.0, 1e-7);
    if (std::isnan(point.x)) {
      EXPECT_EQ(i % 16, 8u);  // at one degree upwards, the ceiling is 115 m away
      ++none;
      continue;
    }
    const bool on_wall = std::abs(point.x - 5.0) < 1e-4, on_floor = std::abs(point.z + 1.0) < 1e-4;
    const bool on_ceiling = std::abs(point.z - 2.0) < 1e-4;
    EXPECT_TRUE(on_wall || on_floor || on_ceiling);
    wall += on_wall;
    floor += on_floor;
    ceiling += on_ceiling;
    const double elevation = std::atan2(point.z, std::hypot(point.x, point.y));
    EXPECT_NEAR(elevation, lidar.elevations[i % 16], 1e-6);
  }
  EXPECT_GT(wall, 5000);
  EXPECT_GT(floor, 5000);
  EXPECT_GT(ceiling, 5000);
  EXPECT_GT(none, 800);
  EXPECT_LT(none, 1000);  // about half a turn
}

TEST(LidarModel, TurnsClockwiseStartingBehindTheSensor) {
  LidarModel lidar = lidarModels().front();
  Random random(1);
  const World world = worldOf({{{-3, 0, 1}, {1, 1, 2}}, {{0, 3, 1}, {1, 1, 2}}});
  const PointCloud cloud = sweep(lidar, world, SteadyMotion(), kNoOffset, 0.0, random);
  const auto level_ring = [&](std::size_t column) { return cloud.points[column * 16 + 8]; };
  EXPECT_NEAR(level_ring(2).x, -2.5, 0.1);
  EXPECT_NEAR(level_ring(452).y, 2.5, 0.1);  // a quarter of a turn later it looks to the left
}

TEST(LidarModel, EachColumnIsCastAtItsOwnTime) {
  LidarModel lidar = lidarModels().front();
  lidar.errors = BeamErrors();
  SteadyMotion motion;
  motion.velocity = {3.0, 0.0, 0.0};
  Random random(1);
  const PointCloud cloud = sweep(lidar, wallAt(5.0), motion, kNoOffset, 0.0, random);
  int compared = 0;
  for (const PointCloud::Point& point : cloud.points) {
    if (std::isnan(point.x) || point.x < 4.0F || std::abs(point.z) > 0.9F) continue;
    EXPECT_NEAR(point.x, 5.0 - 3.0 * point.time, 1e-5);
    ++compared;
  }
  EXPECT_GT(compared, 2000);
}

}  // namespace
}  // namespace kestrel
