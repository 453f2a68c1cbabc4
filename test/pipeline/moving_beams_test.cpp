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

int ghostsWhileHeStands(bool keep_out) {
  MappingStage stage(MapperConfig(), keep_out);
  Room room;
  for (int i = 0; i < 95; ++i) {
    PlanarScan scan = room.scan(i, Pose2(0.02 * i, 0.0, 0.0), walkerAt(i));
    stage.process(scan, std::nullopt);
  }
  return ghostCells(stage.mapper());
}

TEST(MovingBeams, WhatMovesIsNotInTheMap) {
  EXPECT_GT(ghostsWhileHeStands(false), 2);
  EXPECT_EQ(ghostsWhileHeStands(true), 0);
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
