// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "kestrel_slam/simulation/world.h"
#include "simulation/cast.h"

namespace kestrel {
namespace {

/// Two who meet head on, one who is faster than both, and one who crosses their way.
World::Parts meetings() {
  World::Parts parts;
  parts.walkers = {{{{-4.0, 0.0}, {4.0, 0.0}}, 1.2, 0.0},
                   {{{4.0, 0.1}, {-4.0, 0.1}}, 0.9, 0.0},
                   {{{-4.0, 0.0}, {4.0, 0.0}}, 1.5, 14.0},
                   {{{0.0, -4.0}, {0.3, -0.1}}, 1.0, 0.0}};
  Box wall;
  wall.center = {0.0, 0.75, 1.0};
  wall.size = {8.0, 0.1, 2.0};
  parts.boxes = {wall};
  return parts;
}

constexpr double kEnd = 120.0, kEvery = 0.02;  // s

TEST(Crowd, PeopleKeepApart) {
  const World world(meetings());
  double nearest = std::numeric_limits<double>::infinity();
  for (double time = 0.0; time < kEnd; time += kEvery) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        nearest = std::min(nearest, (world.walkerAt(i, time) - world.walkerAt(j, time)).norm());
      }
    }
  }
  EXPECT_GT(nearest, kBodyDistance - 0.01);
  EXPECT_LT(nearest, 1.0);  // they do meet
}

TEST(Crowd, PeopleWalkAtTheirSpeedsAndGetOn) {
  const World world(meetings());
  for (std::size_t i = 0; i < 4; ++i) {
    const double wanted = world.parts().walkers[i].speed_m_s;
    double way = 0.0;
    for (double time = 0.0; time < kEnd; time += kEvery) {
      const double step = (world.walkerAt(i, time + kEvery) - world.walkerAt(i, time)).norm();
      ASSERT_LT(step / kEvery, 1.001 * wanted) << i << " at " << time << " s";
      way += step;
    }
    EXPECT_GT(way, 0.6 * wanted * kEnd) << i;
  }
}

TEST(Crowd, PeopleStayNearTheirPathsAndOutOfWalls) {
  const World world(meetings());
  for (std::size_t i = 0; i < 4; ++i) {
    const double aside = mostAside(world.parts().walkers, i);
    EXPECT_GT(aside, 0.0);
    for (double time = 0.0; time < kEnd; time += kEvery) {
      const Eigen::Vector2d place = world.walkerAt(i, time);
      ASSERT_LE(world.parts().walkers[i].distanceToPath(place), aside + 0.01);
      ASSERT_LT(place.y(), 0.7 - 0.2) << i << " at " << time << " s";
    }
  }
}

TEST(Crowd, PlacesDoNotDependOnWhatWasAskedBefore) {
  const World forwards(meetings()), backwards(meetings());
  std::vector<Eigen::Vector2d> places;
  for (double time = 0.0; time < 30.0; time += 0.1) places.push_back(forwards.walkerAt(2, time));
  for (double time = 30.0; time > 0.0; time -= 0.1) backwards.walkerAt(0, time);
  std::size_t i = 0;
  for (double time = 0.0; time < 30.0; time += 0.1) {
    ASSERT_EQ(backwards.walkerAt(2, time), places[i++]);
  }
  EXPECT_EQ(forwards.walkerAt(1, -5.0), forwards.walkerAt(1, 0.0));
}

TEST(Crowd, WhoMeetsNobodyWalksAsIfAlone) {
  World::Parts parts = meetings();
  parts.walkers.push_back({{{-4.0, -3.0}, {-3.0, -3.0}}, 1.0, 0.0});
  const World world(parts);
  EXPECT_EQ(mostAside(parts.walkers, 4), 0.0);
  for (double time = -1.0; time < 30.0; time += 0.1) {
    ASSERT_EQ(world.walkerAt(4, time), parts.walkers[4].at(time));
  }
}

TEST(Crowd, BeamsHitPeopleWhereTheyAre) {
  const World world(meetings());
  for (double time = 0.0; time < 30.0; time += 0.5) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector2d place = world.walkerAt(i, time);
      EXPECT_NEAR(distance(world, {place.x(), place.y(), 2.5}, {0, 0, -1}, time), 2.5 - 1.75, 1e-9);
    }
  }
}

}  // namespace
}  // namespace kestrel
