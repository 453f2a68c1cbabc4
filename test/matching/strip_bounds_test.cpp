// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/matching/strip_bounds.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "../../src/matching/tile_bounds.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr int kLanes = StripBounds::kLanes;

/// Points anywhere, also far outside of the map.
std::vector<RotatedPoint> randomPoints(int reach, int sides, std::mt19937& random) {
  std::uniform_int_distribution<int> at(-reach, reach), image(0, sides);
  std::vector<RotatedPoint> result;
  for (int n = 0; n < 160; ++n) result.push_back({at(random), at(random), image(random)});
  return result;
}

int sumAt(const BoundImages& images, const std::vector<RotatedPoint>& points, int x, int y) {
  int sum = 0;
  for (const RotatedPoint& p : points) sum += images.valueAt(p.image, x + p.x, y + p.y);
  return sum;
}

class Strips : public testing::TestWithParam<int> {
 protected:
  Submap map_ = room::map();
  BoundImages images_{map_};
  std::mt19937 random_{7};
};

TEST_P(Strips, GiveTheSumOfEveryBlock) {
  const std::vector<RotatedPoint> blocks = randomPoints(GetParam(), 10, random_);
  const std::vector<RotatedPoint> parts = randomPoints(GetParam(), 2, random_);
  for (const BoundImages::Tile& tile : images_.tiles()) {
    const int y = tile.y + 8;
    StripBounds strip;
    strip.set(images_, RotatedPoints(images_, blocks), tile.x, y, 0xFFFF);
    const RotatedPoints rotated(images_, parts);
    for (int phase = 0; phase < 4; ++phase) {
      ASSERT_EQ(strip.within(images_, rotated, tile.x + phase, y + 1, 1), 0xFFFFU);
      for (int i = 0; i < kLanes; ++i)
        EXPECT_EQ(strip.sums()[static_cast<std::size_t>(i)],
                  sumAt(images_, parts, tile.x + phase + 4 * i, y + 1));
    }
    const TileSums sums = boundsIn(images_, blocks, tile);
    for (int i = 0; i < kLanes; ++i)
      EXPECT_EQ(sums[static_cast<std::size_t>(2 * kLanes + i)],
                sumAt(images_, blocks, tile.x + 4 * i, y));
  }
}

/// What is left out is below the limit, and so are the blocks that do not count.
TEST_P(Strips, ReturnTheLanesThatReachTheLimit) {
  const std::vector<RotatedPoint> points = randomPoints(GetParam(), 10, random_);
  constexpr unsigned kCounting = 0b1011'0110'1111'1101;
  for (const BoundImages::Tile& tile : images_.tiles()) {
    const int limit = sumAt(images_, points, tile.x + 24, tile.y + 4);
    StripBounds strip;
    const RotatedPoints rotated(images_, points);
    strip.set(images_, rotated, tile.x, tile.y + 4, kCounting);
    unsigned expected = 0;
    for (int i = 0; i < kLanes; ++i)
      if (sumAt(images_, points, tile.x + 4 * i, tile.y + 4) >= limit) expected |= 1U << i;
    EXPECT_EQ(strip.within(images_, rotated, tile.x, tile.y + 4, limit), expected & kCounting);
  }
}

INSTANTIATE_TEST_SUITE_P(Reach, Strips, testing::Values(40, 150, 1000));

}  // namespace
}  // namespace kestrel
