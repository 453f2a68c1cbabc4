// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

template <int D>
Eigen::Matrix<float, D, 1> onX(float x) {
  Eigen::Matrix<float, D, 1> point = Eigen::Matrix<float, D, 1>::Constant(0.05F);
  point(0) = x;
  return point;
}

template <int D>
std::vector<GridRay<D>> rayTo(float x, bool hit = true) {
  return {{onX<D>(0.05F), onX<D>(x), hit, false}};
}

double logOdds(double p) { return std::log(p / (1.0 - p)); }

MotionGridConfig exactConfig() {
  MotionGridConfig config;
  config.tolerance_m = config.tolerance_rad = 0.0;
  return config;
}

template <typename Dimension>
class MotionGridTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(MotionGridTest, Dimensions);

/// Brings the cell at x = 2.05 m into a state by rays.
template <int D>
void bring(MotionGrid<D>& grid, CellState state) {
  for (int i = 0; i < 20; ++i) {
    if (state == CellState::kFree) grid.insert(rayTo<D>(4.05F, false), 0.1);
    if (state == CellState::kOccupied) grid.insert(rayTo<D>(2.05F), 0.1);
  }
}

/// All rows of table 1 and table 2 of the paper: change of the log odds of both grids.
TYPED_TEST(MotionGridTest, UpdatesFollowBothTables) {
  constexpr int D = TypeParam::value;
  struct Row {
    CellState state;
    bool hit, imposed;
    double static_value, dynamic_value;
    CellMotion motion;
  };
  const MotionGridConfig c = exactConfig();
  const std::vector<Row> rows = {
      {CellState::kFree, false, false, c.low, c.low, CellMotion::kNone},
      {CellState::kUnobserved, false, false, c.low, c.low, CellMotion::kNone},
      {CellState::kOccupied, false, false, c.low, c.low, CellMotion::kNone},
      {CellState::kFree, true, false, c.medium, c.high, CellMotion::kMoving},
      {CellState::kUnobserved, true, true, c.medium, c.high, CellMotion::kMoving},
      {CellState::kUnobserved, true, false, c.high, c.low, CellMotion::kStatic},
      {CellState::kOccupied, true, false, c.high, c.low, CellMotion::kStatic}};
  for (const Row& row : rows) {
    MotionGrid<D> grid(c);
    bring(grid, row.state);
    const GridIndex<D> cell = grid.indexOf(onX<D>(2.05F));
    ASSERT_EQ(grid.staticState(cell), row.state);
    if (row.imposed) {
      // Something moves at 1.75 m, and the next scan sees it 0.3 m farther.
      for (int i = 0; i < 10; ++i) grid.insert(rayTo<D>(1.85F, false), 0.1);
      grid.insert(rayTo<D>(1.75F), 0.1);
      grid.impose(
          [](const auto&) -> Eigen::Matrix<float, D, 1> { return onX<D>(0.3F) - onX<D>(0.0F); },
          0.0);
      ASSERT_TRUE(grid.isImposed(cell));
    }
    const auto before =
        std::pair(logOdds(grid.staticProbability(cell)), logOdds(grid.dynamicProbability(cell)));
    const auto& result = grid.insert(row.hit ? rayTo<D>(2.05F) : rayTo<D>(4.05F, false), 0.1);
    EXPECT_EQ(result.motion[0], row.motion);
    EXPECT_EQ(result.moving.size(), row.motion == CellMotion::kMoving ? 1U : 0U);
    const auto bounded = [&](double odds) {
      return std::clamp(odds, logOdds(c.min_probability), logOdds(c.max_probability));
    };
    EXPECT_NEAR(logOdds(grid.staticProbability(cell)),
                bounded(before.first + logOdds(row.static_value)), 1e-4);
    EXPECT_NEAR(logOdds(grid.dynamicProbability(cell)),
                bounded(before.second + logOdds(row.dynamic_value)), 1e-4);
  }
}

TYPED_TEST(MotionGridTest, WhatStopsBecomesStaticAndAWallComesBack) {
  constexpr int D = TypeParam::value;
  MotionGrid<D> grid(exactConfig());
  bring(grid, CellState::kFree);
  int moving = 0;
  while (grid.insert(rayTo<D>(2.05F), 0.1).motion[0] == CellMotion::kMoving)
    ASSERT_LT(++moving, 200);
  EXPECT_GT(moving, 5);
  for (int i = 0; i < 100; ++i) grid.insert(rayTo<D>(2.05F), 0.1);
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(2.05F))), CellState::kOccupied);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStopped);
  // It goes away: the cell is free again, and nothing remembers it.
  bring(grid, CellState::kFree);
  bring(grid, CellState::kFree);
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(2.05F))), CellState::kFree);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kMoving);
}

TYPED_TEST(MotionGridTest, TimeUntilStaticDoesNotDependOnTheRate) {
  constexpr int D = TypeParam::value;
  const auto secondsUntilStatic = [](double period) {
    MotionGrid<D> grid(exactConfig());
    for (int i = 0; i < 100; ++i) grid.insert(rayTo<D>(4.05F, false), period);
    double seconds = 0.0;
    while (grid.insert(rayTo<D>(2.05F), period).motion[0] == CellMotion::kMoving) seconds += period;
    return seconds;
  };
  EXPECT_NEAR(secondsUntilStatic(0.025), secondsUntilStatic(0.1), 0.15);
}

TYPED_TEST(MotionGridTest, NoiseOfAWallDoesNotMove) {
  constexpr int D = TypeParam::value;
  MotionGrid<D> grid;
  Random random(1);
  int moving = 0;
  for (int i = 0; i < 500; ++i) {
    const auto x = static_cast<float>(3.0 + 0.03 * random.gaussian());
    if (grid.insert(rayTo<D>(x), 0.1).motion[0] == CellMotion::kMoving) ++moving;
  }
  EXPECT_EQ(moving, 0);
}

TYPED_TEST(MotionGridTest, BadRaysAreIgnored) {
  constexpr int D = TypeParam::value;
  MotionGrid<D> grid;
  std::vector<GridRay<D>> rays = rayTo<D>(std::nanf(""));
  rays.push_back(rayTo<D>(INFINITY)[0]);
  rays.push_back(rayTo<D>(3e38F)[0]);
  const auto& result = grid.insert(rays, 0.1);
  for (const CellMotion motion : result.motion) EXPECT_EQ(motion, CellMotion::kNone);
  EXPECT_EQ(grid.memoryBytes(), MotionGrid<D>().memoryBytes());
}

TYPED_TEST(MotionGridTest, ForgetsWhatIsFar) {
  constexpr int D = TypeParam::value;
  MotionGridConfig config;
  config.keep_radius_m = 5.0;
  MotionGrid<D> grid(config);
  grid.insert(rayTo<D>(30.0F), 0.1);
  const std::size_t before = grid.memoryBytes();
  grid.forgetFar(onX<D>(0.0F));
  EXPECT_LT(grid.memoryBytes(), before);
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(30.0F))), CellState::kUnobserved);
  EXPECT_LT(grid.staticProbability(grid.indexOf(onX<D>(1.0F))), 0.5);
}

TYPED_TEST(MotionGridTest, BeamWithoutReturnClearsNothingButWhatHasLeft) {
  constexpr int D = TypeParam::value;
  MotionGrid<D> grid;
  bring(grid, CellState::kOccupied);
  std::vector<GridRay<D>> ray = rayTo<D>(4.05F, false);
  ray[0].presumed = true;
  for (int i = 0; i < 100; ++i) grid.insert(ray, 0.1);
  // What was seen at this range gives no return any more: it has left, or it is glass.
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(2.05F))), CellState::kUnobserved);
  EXPECT_TRUE(grid.wasPassed(grid.indexOf(onX<D>(2.05F))));
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(1.05F))), CellState::kFree);
  EXPECT_EQ(grid.staticState(grid.indexOf(onX<D>(3.05F))), CellState::kUnobserved);
}

TYPED_TEST(MotionGridTest, WhatIsSeenInUnknownSpaceIsNewForAWhile) {
  constexpr int D = TypeParam::value;
  MotionGridConfig config;
  config.new_s = 1.0;
  MotionGrid<D> grid(config);
  grid.insert(rayTo<D>(1.05F), 0.1);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kNew);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.5).motion[0], CellMotion::kNew);
  grid.insert(rayTo<D>(2.05F), 0.6);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStatic);
}

TYPED_TEST(MotionGridTest, AWallThatWasTakenForMovingComesBack) {
  constexpr int D = TypeParam::value;
  MotionGridConfig config;
  config.stopped_s = 5.0;
  MotionGrid<D> grid(config);
  for (int i = 0; i < 20; ++i) grid.insert(rayTo<D>(3.05F), 0.1);  // frees what is before it
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kMoving);
  for (int i = 0; i < 30; ++i) grid.insert(rayTo<D>(2.05F), 0.1);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStopped);
  for (int i = 0; i < 30; ++i) grid.insert(rayTo<D>(2.05F), 0.1);
  EXPECT_EQ(grid.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStatic);
}

// A claim says that something moves, but not that it was not always there.
TYPED_TEST(MotionGridTest, OnlyWhatWasFreeHasBeenComeTo) {
  constexpr int D = TypeParam::value;
  MotionGridConfig config;
  config.new_s = 1.0;
  MotionGrid<D> come(config), claimed(config);
  for (int i = 0; i < 20; ++i) come.insert(rayTo<D>(3.05F), 0.1);  // frees what is before it
  claimed.insert(rayTo<D>(1.05F), 0.1);
  EXPECT_TRUE(come.insert(rayTo<D>(2.05F), 0.1).has_come[0]);
  EXPECT_FALSE(claimed.insert(rayTo<D>(2.05F), 0.1).has_come[0]);
  claimed.claim(onX<D>(2.05F));
  for (int i = 0; i < 30; ++i) {
    EXPECT_TRUE(come.insert(rayTo<D>(2.05F), 0.1).has_come[0]) << i;
    EXPECT_FALSE(claimed.insert(rayTo<D>(2.05F), 0.1).has_come[0]) << i;
  }
  EXPECT_EQ(come.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStopped);
  EXPECT_EQ(claimed.insert(rayTo<D>(2.05F), 0.1).motion[0], CellMotion::kStopped);
}

// The roof of a parked car lies in a voxel through whose upper part beams pass to what is behind
// it.
TEST(MotionGridHeight, WhatComesIntoViewBelowTheBeamsHasNotCome) {
  MotionGridConfig config = exactConfig();
  config.resolution_m = 0.4;
  MotionGrid<3> grid(config);
  const auto beamTo = [](float x, float z) {
    return std::vector<GridRay<3>>{{{0.1F, 0.1F, 0.35F}, {x, 0.1F, z}, true, false}};
  };
  for (int i = 0; i < 20; ++i) grid.insert(beamTo(5.0F, 0.35F), 0.1);
  EXPECT_TRUE(grid.wasPassedAt({3.0F, 0.1F, 0.36F}));
  EXPECT_FALSE(grid.wasPassedAt({3.0F, 0.1F, 0.1F}));
  const auto below = grid.insert(beamTo(3.0F, 0.1F), 0.1);
  EXPECT_TRUE(below.was_free[0]);
  EXPECT_FALSE(below.has_come[0]);
  EXPECT_TRUE(grid.insert(beamTo(2.0F, 0.38F), 0.1).has_come[0]);
}

/// Cells that many points of the segment lie in.
template <int D>
std::set<std::vector<int>> sampledCells(const Eigen::Matrix<float, D, 1>& from,
                                        const Eigen::Matrix<float, D, 1>& to) {
  std::set<std::vector<int>> cells;
  constexpr int kSamples = 20000;
  for (int i = 0; i <= kSamples; ++i) {
    std::vector<int> cell;
    for (int k = 0; k < D; ++k) {
      cell.push_back(static_cast<int>(
          std::floor(from(k) + (static_cast<double>(to(k)) - from(k)) * i / kSamples)));
    }
    cells.insert(cell);
  }
  return cells;
}

TYPED_TEST(MotionGridTest, TraversalVisitsExactlyTheCellsOfTheSegment) {
  constexpr int D = TypeParam::value;
  Random random(2);
  for (int trial = 0; trial < 40; ++trial) {
    Eigen::Matrix<float, D, 1> from, to;
    for (int k = 0; k < D; ++k) {
      from(k) = static_cast<float>(random.uniform(-6.0, 6.0));
      to(k) = static_cast<float>(random.uniform(-6.0, 6.0));
    }
    std::set<std::vector<int>> visited;
    traverse<D>(from, to, [&](const GridIndex<D>& index) {
      visited.insert(std::vector<int>(index.data(), index.data() + D));
      return true;
    });
    std::set<std::vector<int>> expected = sampledCells<D>(from, to);
    std::vector<int> last;
    for (int k = 0; k < D; ++k) last.push_back(static_cast<int>(std::floor(to(k))));
    expected.erase(last);
    EXPECT_EQ(visited.count(last), 0U);
    // Samples miss cells of which the segment cuts a corner shorter than a step.
    for (const auto& cell : expected) EXPECT_EQ(visited.count(cell), 1U);
    EXPECT_LE(visited.size(), expected.size() + 2);
  }
}

/// The beams of a scan share their first cells: the grid must not depend on which of them passes.
TEST(MotionGridBeams, SharedCellsAreAsWithEveryBeamAlone) {
  const int n = 361;
  Random random(4);
  std::vector<GridRay<2>> rays;
  for (int i = 0; i < n; ++i) {
    const double bearing = (i - n / 2) * 0.25 * kPi / 180.0;
    const double range = i % 90 < 12 ? 2.0 : 8.0 + 0.3 * random.gaussian();  // objects in front
    const Eigen::Vector2d end(range * std::cos(bearing), range * std::sin(bearing));
    rays.push_back({Eigen::Vector2f(0.02F, 0.01F), end.cast<float>(), true, false});
  }
  MotionGrid<2> together(exactConfig());
  for (int k = 0; k < 10; ++k) together.insert(rays, 0.1);
  std::set<std::pair<int, int>> passed, ends;
  for (const GridRay<2>& ray : rays) {
    const GridIndex<2> end = together.indexOf(ray.end);
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) ends.insert({end.x() + x, end.y() + y});
    }
    traverse<2>(ray.origin * 10.0F, ray.end * 10.0F, [&](const GridIndex<2>& cell) {
      passed.insert({cell.x(), cell.y()});
      return true;
    });
  }
  std::size_t cleared = 0, missed = 0;
  for (const auto& [x, y] : passed) {
    if (ends.count({x, y}) > 0) continue;
    (together.staticState({x, y}) == CellState::kFree ? cleared : missed) += 1;
  }
  EXPECT_GT(cleared, 3000U);
  EXPECT_LE(missed, cleared / 100) << "only corners of cells";
  // Nothing behind the objects is cleared.
  for (int i = 4; i < 9; ++i) {
    const double bearing = (i - n / 2) * 0.25 * kPi / 180.0;
    const Eigen::Vector2d behind(4.0 * std::cos(bearing), 4.0 * std::sin(bearing));
    EXPECT_NE(together.staticState(together.indexOf(behind.cast<float>())), CellState::kFree);
  }
}

}  // namespace
}  // namespace kestrel
