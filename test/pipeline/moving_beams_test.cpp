// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/moving_beams.h"

#include <gtest/gtest.h>

#include "kestrel_slam/pipeline/mapping_stage.h"
#include "tracking/walker_room.h"

namespace kestrel {
namespace {

/// A walker comes, stops for a while in front of the vehicle, and goes.
std::vector<Disk> walkerAt(int i) {
  if (i < 20) return {};
  const int steps = std::min(i - 20, 40) + std::max(0, i - 100);
  return {{{-4.5 + 0.1 * steps, 2.0}, 0.2}};
}

/// Occupied cells on the way of the walker.
int ghostCells(const Mapper& mapper) {
  const MapSnapshot map = mapper.snapshot();
  int ghosts = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double px = map.origin_x + (x + 0.5) * map.resolution_m;
      const double py = map.origin_y + (y + 0.5) * map.resolution_m;
      const bool on_way = std::abs(px) < 5.0 && std::abs(py - 2.0) < 0.4;
      if (on_way && map.cells[static_cast<std::size_t>(y * map.width + x)] > 50) ++ghosts;
    }
  }
  return ghosts;
}

/// `later`: whether he is kept out from the 10th scan on, before he comes.
int ghostsWhileHeStands(bool at_start, bool later) {
  MappingStage stage(MapperConfig(), at_start);
  Room room;
  for (int i = 0; i < 95; ++i) {
    if (i == 10) stage.keepOutMoving(later);
    PlanarScan scan = room.scan(i, Pose2(0.02 * i, 0.0, 0.0), walkerAt(i));
    stage.process(scan, std::nullopt);
  }
  return ghostCells(stage.mapper());
}

TEST(MovingBeams, WhatMovesIsNotInTheMap) {
  EXPECT_GT(ghostsWhileHeStands(false, false), 2);
  EXPECT_EQ(ghostsWhileHeStands(true, true), 0);
}

TEST(MovingBeams, AreSwitchedInFlight) {
  EXPECT_EQ(ghostsWhileHeStands(false, true), 0);
  EXPECT_GT(ghostsWhileHeStands(true, false), 2);
}

TEST(MovingBeams, BeamsOnWallsStay) {
  MappingStage stage(MapperConfig(), true);
  Room room;
  for (int i = 0; i < 120; ++i) {
    PlanarScan scan = room.scan(i, Pose2(0.02 * i, 0.0, 0.01 * i), {});
    stage.process(scan, std::nullopt);
    EXPECT_EQ(scan.hitCount(), scan.rays.size()) << i;
  }
}

}  // namespace
}  // namespace kestrel
