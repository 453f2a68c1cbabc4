// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/matching/likelihood_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "room.h"

namespace kestrel {
namespace {

constexpr int kMaxLevels = 6;

/// Posts in the corners of tiles, so that windows extend over two tiles.
Submap postsAtTileBorders() {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  for (const float x : {-1.6F, 0.0F, 1.6F, 3.2F}) {
    for (const float y : {-1.6F, 0.0F, 1.6F}) {
      const Eigen::Vector2f post(x + 0.55F, y + 0.52F);
      scan.rays.push_back({post, post, true});
    }
  }
  map.insert(scan, Pose2());
  return map;
}

int bruteForceMaximum(const LikelihoodImage& image, int level, int x, int y) {
  int most = 0;
  for (int j = y; j < y + (1 << level); ++j) {
    for (int i = x; i < x + (1 << level); ++i) most = std::max<int>(most, *image.at(0, i, j));
  }
  return most;
}

/// For every motion of every point of `grid`: the value is the maximum of the window, rounded up to
/// 1/63.
void expectMaxima(const SearchGrid& grid, const LikelihoodImage& image) {
  std::vector<PointCell> cells(static_cast<std::size_t>(grid.pointCount()));
  const int steps = grid.linearSteps(), levels = image.levels();
  for (int k = -grid.angularSteps(); k <= grid.angularSteps(); ++k) {
    grid.rotate(k, 0, grid.pointCount(), image.box(), cells.data());
    for (const PointCell& cell : cells) {
      for (int level = 1; level < levels; ++level) {
        for (int dy = -steps; dy <= steps; dy += 3) {
          for (int dx = -steps; dx <= steps; dx += 2) {
            const int most = bruteForceMaximum(image, level, cell.x + dx, cell.y + dy);
            const int bound = *image.at(level, cell.x + dx, cell.y + dy);
            ASSERT_GE(LikelihoodImage::likelihoodOf(level, bound), most);
            ASSERT_LE(bound, (most + 3) / 4);
            ASSERT_GE(bound * LikelihoodImage::kMax, most * LikelihoodImage::kCoarseMax);
          }
        }
      }
    }
  }
}

TEST(LikelihoodImage, HasTheMaximaOfAllWindowsOfASearch) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<float> position(-4.0F, 4.0F);
  for (int i = 0; i < 12; ++i) {
    const Submap map = i % 2 == 0 ? postsAtTileBorders() : room::map();
    Points points;
    for (int n = 0; n < 12; ++n) points.emplace_back(position(random), position(random));
    const SearchGrid grid(map.surface(), points, Pose2(0.3, 0.2, 0.1 * i), {0.1 * i, 0.1},
                          CorrelativeConfig());
    expectMaxima(grid, LikelihoodImage(map.surface(), grid, i % 3, 0.1, 2 + i % (kMaxLevels - 1)));
  }
}

TEST(LikelihoodImage, AdjacentWindowsAreNeighborsInMemory) {
  const Submap map = room::map();
  const Points points = {Eigen::Vector2f(3.9F, 2.9F)};
  const SearchGrid grid(map.surface(), points, Pose2(), {0.8, 0.1}, CorrelativeConfig());
  const LikelihoodImage image(map.surface(), grid, 0, 0.1, 4);
  PointCell cell{};
  grid.rotate(0, 0, 1, image.box(), &cell);
  for (int level = 0; level < 4; ++level) {
    for (int n = 0; n < 3; ++n) {
      EXPECT_EQ(image.at(level, cell.x, cell.y) + n,
                image.at(level, cell.x + (n << level), cell.y));
      EXPECT_EQ(image.at(level, cell.x, cell.y) + n * image.stride(),
                image.at(level, cell.x, cell.y + n));
    }
  }
}

}  // namespace
}  // namespace kestrel
