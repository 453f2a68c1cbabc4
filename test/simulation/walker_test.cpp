// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/simulation/world.h"
#include "simulation/cast.h"

namespace kestrel {
namespace {

World worldWith(const Walker& walker) {
  World::Parts parts;
  parts.walkers.push_back(walker);
  return World(std::move(parts));
}

TEST(Walker, WalksAroundItsPolygon) {
  const Walker walker = {
      {{0, 0}, {4, 0}, {4, 3}}, 1.0, 0.0};  // 3-4-5 triangle with a circumference of 12 m
  EXPECT_TRUE(walker.at(0.0).isApprox(Eigen::Vector2d(0, 0)));
  EXPECT_TRUE(walker.at(2.5).isApprox(Eigen::Vector2d(2.5, 0)));
  EXPECT_TRUE(walker.at(5.0).isApprox(Eigen::Vector2d(4, 1)));
  EXPECT_TRUE(walker.at(9.5).isApprox(Eigen::Vector2d(2, 1.5)));
  EXPECT_TRUE(walker.at(12.0 + 2.5).isApprox(Eigen::Vector2d(2.5, 0)));
  EXPECT_TRUE(walker.at(-1.0).isApprox(Eigen::Vector2d(0.8, 0.6)));
  const Walker late = {walker.corners, 2.0, 3.0};
  EXPECT_TRUE(late.at(1.0).isApprox(Eigen::Vector2d(4, 1)));
}

TEST(Walker, TrunkIsAboveThePosition) {
  const World world = worldWith({{{5, -10}, {5, 10}}, 1.0, 0.0});
  // At 10 s it is at (5, 0), and the beam comes from the side.
  EXPECT_NEAR(distance(world, {0, 0, 1.3}, {1, 0, 0}, 10.0), 5.0 - 0.2, 1e-12);
  EXPECT_EQ(distance(world, {0, 0, 1.3}, {1, 0, 0}, 8.0), kInfinity);
  EXPECT_NEAR(distance(world, {0, -2, 1.3}, {1, 0, 0}, 8.0), 5.0 - 0.2, 1e-12);
  EXPECT_EQ(distance(world, {0, 0, 1.8}, {1, 0, 0}, 10.0), kInfinity);
  EXPECT_NEAR(distance(world, {5, 0, 2.5}, {0, 0, -1}, 10.0), 2.5 - 1.75, 1e-12);
  EXPECT_EQ(distance(world, {10, 0, 1.3}, {1, 0, 0}, 10.0), kInfinity);
}

/// The y coordinates of the legs' middles, as seen by parallel beams at a height of 0.3 m.
std::vector<double> legsSeen(const World& world, double time) {
  std::vector<double> legs;
  double begin = 0.0;
  bool before = false;
  for (double y = -1.0; y < 1.0; y += 0.001) {
    const bool leg = std::isfinite(distance(world, {0, y, 0.3}, {1, 0, 0}, time));
    if (leg && !before) begin = y;
    if (before && !leg) legs.push_back((begin + y - 0.001) / 2.0);
    before = leg;
  }
  return legs;
}

TEST(Walker, LegsSwing) {
  const World world = worldWith({{{5, -7}, {5, 7}}, 1.0, 0.0});
  // After five strides of 1.4 m the legs are side by side; a quarter of a stride later they are
  // farthest apart.
  const std::vector<double> together = legsSeen(world, 7.0);
  ASSERT_EQ(together.size(), 1u);
  EXPECT_NEAR(together[0], 0.0, 0.002);
  const std::vector<double> apart = legsSeen(world, 7.35);
  ASSERT_EQ(apart.size(), 2u);
  EXPECT_NEAR(apart[0], 0.35 - 0.25, 0.002);
  EXPECT_NEAR(apart[1], 0.35 + 0.25, 0.002);
}

TEST(Walker, NeedsCorners) { EXPECT_THROW(worldWith({{}, 1.0, 0.0}), std::invalid_argument); }

TEST(Walker, ReturnsTheDistanceToItsPath) {
  const Walker square{{{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {0.0, 2.0}}};
  EXPECT_DOUBLE_EQ(square.distanceToPath({1.0, 0.75}), 0.75);  // to the lower side
  EXPECT_DOUBLE_EQ(square.distanceToPath({-0.5, 1.0}),
                   0.5);  // to the last side, which closes the polygon
  EXPECT_DOUBLE_EQ(square.distanceToPath({5.0, 6.0}), 5.0);  // to a corner
  EXPECT_EQ(Walker().distanceToPath({0.0, 0.0}), kInfinity);
}

}  // namespace
}  // namespace kestrel
