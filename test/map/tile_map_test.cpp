// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/tile_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace kestrel {
namespace {

struct Counter {
  int value = 0;
};
struct Kilobyte {
  std::array<char, 1024> bytes{};
};

constexpr std::size_t kPlenty = 1U << 28U;
constexpr int kLowest = std::numeric_limits<int>::min(), kHighest = std::numeric_limits<int>::max();

TEST(FloorToInt, IsTheFloor) {
  for (const float value :
       {0.0F, -0.0F, 0.999F, 1.0F, -0.001F, -1.0F, -1.001F, -32.0F, 5e8F, -5e8F}) {
    EXPECT_EQ(floorToInt(value), static_cast<int>(std::floor(value))) << value;
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(-5000.0F, 5000.0F);
  for (int i = 0; i < 10000; ++i) {
    const float value = number(random);
    ASSERT_EQ(floorToInt(value), static_cast<int>(std::floor(value))) << value;
  }
}

TEST(OffsetInTile, IsRowMajorAlsoForNegativeCoordinates) {
  EXPECT_EQ(offsetInTile({0, 0}), 0U);
  EXPECT_EQ(offsetInTile({31, 0}), 31U);
  EXPECT_EQ(offsetInTile({32, 1}), 32U);
  EXPECT_EQ(offsetInTile({-1, 0}), 31U);
  EXPECT_EQ(offsetInTile({-32, -32}), 0U);
  EXPECT_EQ(offsetInTile({-1, -1}), 1023U);
}

TEST(TileMap, AnEmptyMapHasNoTiles) {
  TileMap<Counter> tiles(kPlenty);
  for (const int x : {kLowest, -1, 0, kHighest}) {
    for (const int y : {kLowest, -1, 0, kHighest}) EXPECT_EQ(tiles.find({x, y}), nullptr);
  }
  EXPECT_EQ(tiles.memoryBytes(), 0U);
}

TEST(TileMap, TilesKeepTheirAddressWhenTheMapGrows) {
  TileMap<Counter> tiles(kPlenty);
  const std::vector<Cell> cells = {{0, 0},    {-1, -1},    {500, 3},  {-700, 9},
                                   {5, -900}, {-33, 1100}, {4000, 0}, {0, -4000}};
  std::vector<Counter*> places;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Counter* tile = tiles.obtain(cells[i]);
    ASSERT_NE(tile, nullptr);
    EXPECT_EQ(tile->value, 0) << "a new tile must be initialized";
    tile->value = static_cast<int>(i) + 1;
    places.push_back(tile);
    for (std::size_t k = 0; k <= i; ++k) {
      ASSERT_EQ(tiles.find(cells[k]), places[k]) << "after growing to tile " << i;
      ASSERT_EQ(places[k]->value, static_cast<int>(k) + 1);
    }
  }
  EXPECT_EQ(tiles.tileCount(), cells.size());
  EXPECT_EQ(tiles.find({31, 31}), places[0]);
  EXPECT_EQ(tiles.find({32, 0}), nullptr);
  EXPECT_EQ(tiles.find({kLowest, kHighest}), nullptr);
}

TEST(TileMap, AgreesWithAnOrderedMap) {
  TileMap<Counter> tiles(kPlenty);
  std::map<std::pair<int, int>, int> oracle;  // (tile row, tile column), the order of forEach
  std::mt19937 random(2);
  std::uniform_int_distribution<int> coordinate(-3000, 3000);
  for (int i = 0; i < 3000; ++i) {
    const Cell cell{coordinate(random), coordinate(random)};
    const auto key = std::make_pair(cell.y >> kTileShift, cell.x >> kTileShift);
    ASSERT_EQ(tiles.find(cell) != nullptr, oracle.count(key) == 1U);
    ++tiles.obtain(cell)->value;
    ++oracle[key];
  }
  EXPECT_EQ(tiles.tileCount(), oracle.size());
  auto expected = oracle.begin();
  tiles.forEach([&](const Cell& corner, const Counter& tile) {
    ASSERT_NE(expected, oracle.end());
    EXPECT_EQ(corner,
              (Cell{expected->first.second * kTileSide, expected->first.first * kTileSide}));
    EXPECT_EQ(tile.value, expected->second);
    ++expected;
  });
  EXPECT_EQ(expected, oracle.end());
}

TEST(TileMap, FindsTheTilesOfFourCellsLikeThoseOfEach) {
  TileMap<Counter> tiles(kPlenty);
  FourInts slots;
  EXPECT_FALSE(tiles.findSlots(FourInts{}, FourInts{}, slots)) << "there is no index yet";
  std::mt19937 random(4);
  std::uniform_int_distribution<int> coordinate(-400, 400), nearby(-600, 600);
  for (int i = 0; i < 50; ++i)
    ASSERT_NE(tiles.obtain({coordinate(random), coordinate(random)}), nullptr);
  int found = 0;
  for (int i = 0; i < 3000; ++i) {
    FourInts x, y;
    for (int k = 0; k < 4; ++k) x[k] = nearby(random), y[k] = nearby(random);
    if (i % 100 == 0) x[i / 100 % 4] = i % 200 == 0 ? kLowest : kHighest;
    const bool is_inside = tiles.findSlots(x, y, slots);
    for (int k = 0; k < 4; ++k) {
      const Cell cell{x[k], y[k]};
      EXPECT_EQ(offsetsInTile(x, y)[k], static_cast<int>(offsetInTile(cell)));
      if (!is_inside) continue;
      ASSERT_EQ(tiles.inSlot(static_cast<std::size_t>(slots[k])), tiles.find(cell));
    }
    found += is_inside ? 1 : 0;
  }
  EXPECT_GT(found, 500);
  EXPECT_LT(found, 2900);
  // Outside of the index on each side, one cell of the four.
  for (const Cell& far : {Cell{-90000, 0}, {90000, 0}, {0, -90000}, {0, 90000}})
    EXPECT_FALSE(tiles.findSlots(FourInts{0, 0, far.x, 0}, FourInts{0, 0, far.y, 0}, slots));
}

/// Obtains tiles around the origin at random and along x, where the index grows continuously.
void expectLimitKept(std::size_t limit) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(-100, 100);
  TileMap<Kilobyte> tiles(limit);
  std::size_t refused = 0;
  for (int i = 0; i < 120; ++i) {
    const Cell cell{i % 2 == 0 ? coordinate(random) : i * kTileSide / 2, coordinate(random)};
    const std::size_t count = tiles.tileCount();
    if (tiles.obtain(cell) == nullptr) {
      ++refused;
      ASSERT_EQ(tiles.tileCount(), count);
    } else {
      ASSERT_EQ(tiles.obtain(cell), tiles.find(cell))
          << "existing tiles must be found at the limit too";
    }
    ASSERT_LE(tiles.memoryBytes(), limit);
  }
  EXPECT_GT(refused, 0U) << "limit " << limit;
}

TEST(TileMap, StaysBelowItsLimitAndKeepsExistingTilesUsable) {
  for (std::size_t limit = 0; limit < 80000; limit += 61) {
    ASSERT_NO_FATAL_FAILURE(expectLimitKept(limit)) << "limit " << limit;
  }
}

TEST(TileMap, RefusesTilesThatNeedAHugeIndexAndStaysUsable) {
  TileMap<Counter> tiles(kPlenty);
  ASSERT_NE(tiles.obtain({0, 0}), nullptr);
  for (const int far : {kLowest, kHighest, 500000000, -500000000}) {
    EXPECT_EQ(tiles.obtain({far, far}), nullptr) << far;
    EXPECT_EQ(tiles.obtain({far, 0}), nullptr) << far;
  }
  EXPECT_EQ(tiles.tileCount(), 1U);
  EXPECT_NE(tiles.obtain({100, -100}), nullptr);
  EXPECT_LT(tiles.memoryBytes(), 10000U);
}

TEST(TileMap, ClearForgetsEverything) {
  TileMap<Counter> tiles(kPlenty);
  tiles.obtain({10, 10})->value = 7;
  tiles.clear();
  EXPECT_EQ(tiles.find({10, 10}), nullptr);
  EXPECT_EQ(tiles.memoryBytes(), 0U);
  EXPECT_EQ(tiles.obtain({-5000, 5000})->value, 0);
}

}  // namespace
}  // namespace kestrel
