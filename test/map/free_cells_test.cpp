// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/free_cells.h"

#include <gtest/gtest.h>

#include <random>

#include "kestrel_slam/map/submap.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr float kCellsPerMeter = 20.0F;
constexpr std::size_t kPlenty = 1U << 28U;

std::size_t countOf(const FreeCells& free) {
  std::size_t count = 0;
  for (const FreeCells::Tile* tile : free.tiles()) {
    for (const std::uint32_t row : tile->rows)
      count += static_cast<std::size_t>(__builtin_popcount(row));
  }
  return count;
}

TEST(FreeCells, AreTheCellsBeforeTheEndOfABeam) {
  PlanarScan scan;
  scan.rays.push_back({{-0.975F, 0.025F}, {2.025F, 0.025F}, true});
  const FreeCells free(scan, Pose2(), kCellsPerMeter, kPlenty);
  EXPECT_EQ(countOf(free), 60U);
  ASSERT_EQ(free.tiles().size(), 3U);
  EXPECT_EQ(free.tiles()[0]->corner, (Cell{-32, 0})) << "the tiles are in the order of the beam";
  EXPECT_EQ(free.tiles()[0]->rows[0], 0xFFFFF000U);
  EXPECT_EQ(free.tiles()[1]->rows[0], 0xFFFFFFFFU);
  EXPECT_EQ(free.tiles()[2]->rows[0], 0x000000FFU);
}

TEST(FreeCells, ABeamWithoutAReturnIsLeftOut) {
  PlanarScan scan;
  PlanarRay ray{{0.0F, 0.0F}, {5.0F, 0.0F}, false};
  ray.no_return = true;
  scan.rays.push_back(ray);
  ray.no_return = false;
  ray.presumed = true;
  scan.rays.push_back(ray);
  EXPECT_TRUE(FreeCells(scan, Pose2(), kCellsPerMeter, kPlenty).tiles().empty());
}

TEST(FreeCells, AMemoryLimitIsReported) {
  PlanarScan scan;
  scan.rays.push_back({{0.0F, 0.0F}, {500.0F, 0.0F}, true});
  EXPECT_TRUE(FreeCells(scan, Pose2(), kCellsPerMeter, 10000).isFull());
  EXPECT_FALSE(FreeCells(scan, Pose2(), kCellsPerMeter, kPlenty).isFull());
}

/// A scan of the room in which some beams have no return, and some are presumed to be free.
PlanarScan scanWithGaps(const Pose2& pose, std::mt19937_64& random) {
  PlanarScan scan = room::scanFrom(pose);
  for (PlanarRay& ray : scan.rays) {
    const std::uint64_t kind = random() % 8;
    if (kind > 1) continue;
    ray.hit = false;
    (kind == 0 ? ray.no_return : ray.presumed) = true;
  }
  return scan;
}

TEST(FreeCells, ServeSeveralMapsLikeCellsOfTheirOwn) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> offset(-1.0, 1.0);
  Submap alone{OccupancyGridConfig()}, first{OccupancyGridConfig()}, second{OccupancyGridConfig()};
  for (std::uint32_t i = 0; i < 20; ++i) {
    const Pose2 pose(offset(random), offset(random), offset(random));
    const PlanarScan scan = scanWithGaps(pose, random);
    const FreeCells free = first.grid().freeCells(scan, pose);
    alone.insert(scan, pose, false, i);
    first.insert(scan, pose, false, i, free);
    if (i >= 10) second.insert(scan, pose, false, i, free);
  }
  EXPECT_EQ(first.grid().snapshot().cells, alone.grid().snapshot().cells);
  EXPECT_EQ(first.surface().size(), alone.surface().size());
  EXPECT_NE(second.grid().snapshot().cells, alone.grid().snapshot().cells);
  for (int y = -90; y < 90; ++y) {
    for (int x = -110; x < 110; ++x) {
      ASSERT_EQ(first.grid().probability({x, y}), alone.grid().probability({x, y}));
      ASSERT_EQ(first.grid().isKnownOrPresumed({x, y}), alone.grid().isKnownOrPresumed({x, y}));
    }
  }
}

}  // namespace
}  // namespace kestrel
