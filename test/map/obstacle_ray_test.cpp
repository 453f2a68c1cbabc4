// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/obstacle_ray.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace kestrel {
namespace {

/// 4 x 3 cells of 0.5 m with a wall in the last column, from x = 1 + 1.5 m.
MapSnapshot wallMap() {
  MapSnapshot map;
  map.resolution_m = 0.5;
  map.origin_x = 1.0;
  map.origin_y = -1.0;
  map.width = 4;
  map.height = 3;
  map.cells = {0, 0, -1, 100, 0, 0, -1, 100, 0, 0, 0, 100};
  return map;
}

TEST(ObstacleRayTest, EndsAtTheWall) {
  const MapSnapshot map = wallMap();
  const auto hit = firstObstacle(map, {1.2, -0.3}, {5.0, 0.0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->x(), 2.5, 1e-12);
  EXPECT_NEAR(hit->y(), -0.3, 1e-12);
  const auto slanted = firstObstacle(map, {1.5, -0.9}, {1.0, 0.5});
  ASSERT_TRUE(slanted);
  EXPECT_NEAR(slanted->x(), 2.5, 1e-12);
  EXPECT_NEAR(slanted->y(), -0.4, 1e-12);
}

TEST(ObstacleRayTest, EntersTheMapFromOutside) {
  const auto hit = firstObstacle(wallMap(), {10.0, -0.3}, {-1.0, 0.0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->x(), 3.0, 1e-12);
}

TEST(ObstacleRayTest, FindsNothingBehindAndOutside) {
  const MapSnapshot map = wallMap();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(firstObstacle(map, {1.2, -0.3}, {-1.0, 0.0}));
  EXPECT_FALSE(firstObstacle(map, {1.2, 5.0}, {1.0, 0.0}));
  EXPECT_FALSE(firstObstacle(map, {1.2, -0.3}, {0.0, 0.0}));
  EXPECT_FALSE(firstObstacle(map, {nan, 0.0}, {1.0, 0.0}));
  EXPECT_FALSE(firstObstacle(map, {1.2, -0.3}, {nan, 0.0}));
  EXPECT_FALSE(firstObstacle(map, {1e300, 0.0}, {-1.0, 0.0}));
  EXPECT_FALSE(firstObstacle(MapSnapshot(), {0.0, 0.0}, {1.0, 0.0}));
}

/// Oracle: tiny steps.
TEST(ObstacleRayTest, AgreesWithTinySteps) {
  const MapSnapshot map = wallMap();
  for (int i = 0; i < 360; ++i) {
    const double angle = 0.01745 * i + 0.003;
    const Eigen::Vector2d start(1.7, -0.2), direction(std::cos(angle), std::sin(angle));
    double expected = -1.0;
    for (double way = 0.0; way < 3.0 && expected < 0.0; way += 1e-4) {
      const Eigen::Vector2d point = start + way * direction;
      const int column = static_cast<int>(std::floor((point.x() - 1.0) / 0.5));
      const int row = static_cast<int>(std::floor((point.y() + 1.0) / 0.5));
      if (column < 0 || row < 0 || column > 3 || row > 2) break;
      if (map.at(column, row) == MapSnapshot::kOccupied) expected = way;
    }
    const auto hit = firstObstacle(map, start, direction);
    ASSERT_EQ(hit.has_value(), expected >= 0.0) << i;
    if (hit) {
      EXPECT_NEAR((*hit - start).norm(), expected, 2e-4) << i;
    }
  }
}

}  // namespace
}  // namespace kestrel
