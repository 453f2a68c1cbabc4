// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/occupancy_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "room.h"

namespace kestrel {
namespace {

constexpr double kRounding = 1e-3;  // log odds are stored in steps of 1/1000

double logOdds(double p) { return std::log(p / (1.0 - p)); }
double logOddsOf(const OccupancyGrid& grid, const Cell& cell) {
  return logOdds(grid.probability(cell));
}

/// One beam along +x from the center of cell (0, 0) to the center of cell (`cells`, 0).
PlanarScan beam(int cells, bool hit, float resolution = 0.05F) {
  const Eigen::Vector2f from(0.5F * resolution, 0.5F * resolution);
  const Eigen::Vector2f to = from + Eigen::Vector2f(static_cast<float>(cells) * resolution, 0.0F);
  PlanarScan scan;
  scan.rays.push_back({from, to, hit});
  return scan;
}

TEST(OccupancyGrid, ABeamClearsItsCellsAndOccupiesTheLast) {
  OccupancyGridConfig config;
  OccupancyGrid grid(config);
  grid.insert(beam(10, true), Pose2());
  for (int x = 0; x < 10; ++x) {
    EXPECT_NEAR(logOddsOf(grid, {x, 0}), logOdds(config.miss_probability), kRounding) << x;
    EXPECT_FALSE(grid.isKnown({x, 1}));
    EXPECT_FALSE(grid.isKnown({x, -1}));
  }
  EXPECT_NEAR(logOddsOf(grid, {10, 0}), logOdds(config.hit_probability), kRounding);
  EXPECT_TRUE(grid.isOccupied({10, 0}));
  EXPECT_FALSE(grid.isKnown({11, 0}));
  EXPECT_FALSE(grid.isKnown({-1, 0}));
}

TEST(OccupancyGrid, BeamWithoutReturnOnlyClears) {
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(beam(10, false), Pose2());
  EXPECT_TRUE(grid.isKnown({9, 0}));
  EXPECT_FALSE(grid.isOccupied({9, 0}));
  EXPECT_FALSE(grid.isKnown({10, 0}));
}

TEST(OccupancyGrid, ABeamWithoutReturnStopsAtAWall) {
  PlanarScan glance = beam(60, false);
  glance.rays[0].no_return = true;
  OccupancyGrid grid{OccupancyGridConfig()};
  for (int i = 0; i < 3; ++i) grid.insert(beam(40, true), Pose2());
  for (int i = 0; i < 50; ++i) grid.insert(glance, Pose2());
  EXPECT_TRUE(grid.isOccupied({40, 0}));
  EXPECT_FALSE(grid.isKnown({41, 0})) << "behind the wall";
  EXPECT_TRUE(grid.isKnown({39, 0}));
  // Also at a wall that was hit in the same scan.
  glance.rays.push_back(beam(20, true).rays[0]);
  grid.clear();
  grid.insert(glance, Pose2());
  EXPECT_TRUE(grid.isOccupied({20, 0}));
  EXPECT_FALSE(grid.isKnown({21, 0}));
}

TEST(OccupancyGrid, PresumablyFreeSpaceIsUsedForTheMatchOnly) {
  PlanarScan glance = beam(60, false);
  glance.rays[0].presumed = true;
  OccupancyGrid grid{OccupancyGridConfig()};
  for (int i = 0; i < 20; ++i) grid.insert(glance, Pose2());
  EXPECT_TRUE(grid.isKnownOrPresumed({30, 0}));
  EXPECT_FALSE(grid.isKnown({30, 0}) || grid.isKnownOrPresumed({30, 1}));
  EXPECT_TRUE(grid.snapshot().empty());
  OccupancyGrid walled{OccupancyGridConfig()};
  walled.insert(beam(40, true), Pose2());
  walled.insert(glance, Pose2());
  EXPECT_FALSE(walled.isKnownOrPresumed({41, 0})) << "behind a wall";
}

TEST(OccupancyGrid, ABeamWithoutReturnDoesNotPassBetweenCellsThatTouchAtACorner) {
  // A diagonal wall of cells (i, 40 - i), and beams across it.
  OccupancyGrid grid{OccupancyGridConfig()};
  PlanarScan wall, glance;
  for (int i = 0; i <= 40; ++i) {
    const Eigen::Vector2f at =
        0.05F * Eigen::Vector2f(static_cast<float>(i) + 0.5F, 40.5F - static_cast<float>(i));
    wall.rays.push_back({at, at, true});
  }
  grid.insert(wall, Pose2());
  for (int i = 0; i < 40; ++i) {
    const float shift = 0.02F * static_cast<float>(i);
    PlanarRay ray{{0.2F + shift, 0.1F}, {1.9F + shift, 1.8F}, false};
    ray.no_return = true;
    glance.rays.push_back(ray);
  }
  grid.insert(glance, Pose2());
  for (int x = 0; x < 60; ++x) {
    for (int y = 41 - x; y < 60; ++y) EXPECT_FALSE(grid.isKnown({x, y})) << x << ", " << y;
  }
}

TEST(OccupancyGrid, EvidenceAddsUpToBothClamps) {
  OccupancyGridConfig config;
  config.hit_probability = 0.6;
  config.miss_probability = 0.45;
  OccupancyGrid grid(config);
  for (int n = 1; n <= 30; ++n) {
    grid.insert(beam(4, true), Pose2());
    EXPECT_NEAR(logOddsOf(grid, {4, 0}),
                std::min(n * logOdds(0.6), logOdds(config.max_probability)), n * kRounding);
    EXPECT_NEAR(logOddsOf(grid, {2, 0}),
                std::max(n * logOdds(0.45), logOdds(config.min_probability)), n * kRounding);
  }
}

TEST(OccupancyGrid, HitsInEstablishedFreeSpaceCountHalf) {
  OccupancyGridConfig config;
  const double hit = logOdds(config.hit_probability), floor = logOdds(config.min_probability);
  OccupancyGrid grid(config);
  for (int n = 0; n < 20; ++n) grid.insert(beam(10, true), Pose2());
  EXPECT_NEAR(logOddsOf(grid, {4, 0}), floor, kRounding);
  // Half of the weight until the cell is no longer established as free.
  double expected = floor;
  for (const double weight : {hit / 2.0, hit / 2.0, hit}) {
    EXPECT_FALSE(grid.isOccupied({4, 0}));
    grid.insert(beam(4, true), Pose2());
    expected += weight;
    EXPECT_NEAR(logOddsOf(grid, {4, 0}), expected, 3.0 * kRounding);
  }
  EXPECT_TRUE(grid.isOccupied({4, 0}));
}

TEST(OccupancyGrid, HitsOfANewViewCountFully) {
  OccupancyGridConfig config;
  OccupancyGrid grid(config);
  for (int n = 0; n < 20; ++n) grid.insert(beam(10, true), Pose2());
  constexpr bool kNewView = true;
  grid.insert(beam(4, true), Pose2(), kNewView);
  EXPECT_NEAR(logOddsOf(grid, {4, 0}),
              logOdds(config.min_probability) + logOdds(config.hit_probability), 3.0 * kRounding);
}

TEST(OccupancyGrid, OneHitIsEnoughInACellWithLittleEvidence) {
  OccupancyGrid grid{OccupancyGridConfig()};
  for (int n = 0; n < 3; ++n) grid.insert(beam(10, true), Pose2());
  grid.insert(beam(4, true), Pose2());
  EXPECT_TRUE(grid.isOccupied({4, 0}));
}

TEST(OccupancyGrid, UpdatesACellOncePerScanAndAHitOverridesMisses) {
  OccupancyGridConfig config;
  OccupancyGrid grid(config);
  PlanarScan scan = beam(10, true);
  for (int i = 0; i < 5; ++i) scan.rays.push_back(beam(20, false).rays.front());
  scan.rays.push_back(beam(10, true).rays.front());
  grid.insert(scan, Pose2());
  EXPECT_NEAR(logOddsOf(grid, {5, 0}), logOdds(config.miss_probability), kRounding);
  EXPECT_NEAR(logOddsOf(grid, {10, 0}), logOdds(config.hit_probability), kRounding);
  EXPECT_NEAR(logOddsOf(grid, {15, 0}), logOdds(config.miss_probability), kRounding);
}

TEST(OccupancyGrid, ReportsCellsThatBecomeFree) {
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(beam(10, true), Pose2());
  int scans = 0;
  while (grid.insert(beam(20, false), Pose2()).became_free.empty() && scans < 100) ++scans;
  // A hit adds 2.2 to the log odds and a miss subtracts 0.41: the sixth miss makes it negative.
  EXPECT_EQ(scans, 5);
  EXPECT_FALSE(grid.isOccupied({10, 0}));
}

TEST(OccupancyGrid, BeamsInEveryDirectionClearOnlyCellsOnTheLine) {
  for (int k = 0; k < 64; ++k) {
    OccupancyGrid grid{OccupancyGridConfig()};
    const double angle = 2.0 * kPi * k / 64;
    const Pose2 pose(-3.21, 7.77, angle);  // the beam crosses tiles and quadrants of the origin
    PlanarScan scan;
    scan.rays.push_back({Eigen::Vector2f::Zero(), Eigen::Vector2f(4.0F, 0.0F), true});
    grid.insert(scan, pose);
    const MapSnapshot map = grid.snapshot();
    int known = 0, occupied = 0;
    for (int row = 0; row < map.height; ++row) {
      for (int column = 0; column < map.width; ++column) {
        if (map.at(column, row) == MapSnapshot::kUnknown) continue;
        ++known;
        occupied += map.at(column, row) == MapSnapshot::kOccupied ? 1 : 0;
        const Eigen::Vector2d center(map.origin_x + (column + 0.5) * map.resolution_m,
                                     map.origin_y + (row + 0.5) * map.resolution_m);
        const Eigen::Vector2d local = pose.inverse() * center;
        EXPECT_LT(std::abs(local.y()), 0.05) << angle;
        EXPECT_GT(local.x(), -0.05);
        EXPECT_LT(local.x(), 4.05);
      }
    }
    EXPECT_EQ(occupied, 1);
    EXPECT_GE(known, 56);  // 80 cells / sqrt(2) on the diagonal
    EXPECT_LE(known, 82);
  }
}

TEST(OccupancyGrid, CoarseLevelsAreMaximaOfLevelZero) {
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(room::scanFrom(Pose2(0.3, -0.2, 0.4)), Pose2(0.3, -0.2, 0.4));
  for (int level = 1; level < OccupancyGrid::kLevels; ++level) {
    const int side = 1 << level;
    for (int y = -20; y < 20; ++y) {
      for (int x = -25; x < 25; ++x) {
        // Unknown cells count as 0.5.
        double maximum = 0.0;
        for (int dy = 0; dy < side; ++dy) {
          for (int dx = 0; dx < side; ++dx) {
            maximum = std::max(maximum, grid.probability({x * side + dx, y * side + dy}));
          }
        }
        ASSERT_EQ(grid.levelProbability(level, {x, y}), maximum) << level << " " << x << " " << y;
      }
    }
  }
}

TEST(OccupancyGrid, InterpolationIsBilinearAndHasTheRightGradient) {
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(room::scanFrom(Pose2()), Pose2());
  constexpr float kStep = 2e-4F;
  for (int level = 0; level < OccupancyGrid::kLevels; ++level) {
    const float size = 0.05F * static_cast<float>(1 << level);
    for (int i = 0; i < 200; ++i) {
      // Inside the square between four centers, because the gradient is discontinuous at its
      // border.
      const int cx = (i * 37) % 90 - 45, cy = (i * 53) % 70 - 35;
      const float u = 0.1F + 0.8F * static_cast<float>(i % 10) / 10.0F, v = 0.9F - 0.7F * u;
      const Eigen::Vector2f p((static_cast<float>(cx) + 0.5F + u) * size,
                              (static_cast<float>(cy) + 0.5F + v) * size);
      const auto m = [&](int dx, int dy) {
        return static_cast<float>(grid.levelProbability(level, {cx + dx, cy + dy}));
      };
      const InterpolatedValue value = grid.interpolate(level, p);
      const float expected =
          v * (u * m(1, 1) + (1 - u) * m(0, 1)) + (1 - v) * (u * m(1, 0) + (1 - u) * m(0, 0));
      ASSERT_NEAR(value.value, expected, 1e-4F);
      const Eigen::Vector2f ex(kStep, 0.0F), ey(0.0F, kStep);
      const float dx =
          (grid.interpolate(level, p + ex).value - grid.interpolate(level, p - ex).value) /
          (2 * kStep);
      const float dy =
          (grid.interpolate(level, p + ey).value - grid.interpolate(level, p - ey).value) /
          (2 * kStep);
      ASSERT_NEAR(value.gradient.x(), dx, 0.02F);
      ASSERT_NEAR(value.gradient.y(), dy, 0.02F);
    }
  }
}

TEST(OccupancyGrid, MemoryIsProportionalToTheVisitedArea) {
  OccupancyGrid grid{OccupancyGridConfig()};
  const auto walk = [&grid](double from, double to) {
    for (double s = from; s < to; s += 1.0) {
      // Diagonally: the memory of a bounding square would grow with the square of the distance.
      const Pose2 pose(s * std::sqrt(0.5), s * std::sqrt(0.5), 0.0);
      grid.insert(room::scanFrom(Pose2()), pose);
    }
    return grid.memoryBytes();
  };
  const double hundred = static_cast<double>(walk(0, 100));
  const double three_hundred = static_cast<double>(walk(100, 300));
  EXPECT_GT(three_hundred, 2.0 * hundred);
  EXPECT_LT(three_hundred, 4.0 * hundred);
}

TEST(OccupancyGrid, ReportsTheMemoryLimitAndStaysUsable) {
  OccupancyGridConfig config;
  config.memory_limit_mb = 0.2;
  OccupancyGrid grid(config);
  EXPECT_FALSE(grid.insert(beam(10, true), Pose2()).full);
  bool full = false;
  for (int i = 0; i < 200; ++i) full |= grid.insert(beam(10, true), Pose2(i, 0.0, 0.0)).full;
  EXPECT_TRUE(full);
  EXPECT_LE(grid.memoryBytes(), 200000U);
  EXPECT_TRUE(grid.isOccupied({10, 0}));
  EXPECT_FALSE(grid.insert(beam(10, true), Pose2()).full);
}

TEST(OccupancyGrid, DistantPlacesDoNotAllocateTheAreaBetween) {
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(beam(10, true), Pose2());
  EXPECT_TRUE(grid.insert(beam(10, true), Pose2(9e5, 9e5, 0.0)).full);
  EXPECT_LE(grid.memoryBytes(), 2048000000U);
  EXPECT_EQ(grid.snapshot().width, 11);
}

TEST(OccupancyGrid, SnapshotHasTheExtentOfTheKnownCells) {
  OccupancyGrid grid{OccupancyGridConfig()};
  EXPECT_TRUE(grid.snapshot().empty());
  grid.insert(beam(10, true), Pose2(-1.0, 2.0, 0.0));
  const MapSnapshot map = grid.snapshot();
  ASSERT_EQ(map.width, 11);
  ASSERT_EQ(map.height, 1);
  EXPECT_NEAR(map.origin_x, -1.0, 1e-9);
  EXPECT_NEAR(map.origin_y, 2.0, 1e-9);
  EXPECT_EQ(map.at(0, 0), MapSnapshot::kFree);
  EXPECT_EQ(map.at(10, 0), MapSnapshot::kOccupied);
  grid.clear();
  EXPECT_TRUE(grid.snapshot().empty());
}

}  // namespace
}  // namespace kestrel
