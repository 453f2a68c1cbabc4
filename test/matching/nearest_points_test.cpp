// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/nearest_points.h"

#include <gtest/gtest.h>

#include <random>

namespace kestrel {
namespace {

constexpr std::uint64_t kPointSeed = 4;

std::vector<WallPoint> randomPoints(std::mt19937_64& random, std::size_t count) {
  std::normal_distribution<float> place(0.0F, 3.0F);
  std::vector<WallPoint> points(count);
  for (WallPoint& point : points) {
    point.position.x() = place(random);
    point.position.y() = place(random);
    point.normal = point.position;  // identifies the point
  }
  return points;
}

/// The nearest point within `reach_m` by brute force, or nullptr.
const WallPoint* bruteForce(const std::vector<WallPoint>& points, const Eigen::Vector2f& place,
                            float reach_m) {
  const WallPoint* best = nullptr;
  float distance2 = reach_m * reach_m;
  for (const WallPoint& point : points) {
    const float other2 = (point.position - place).squaredNorm();
    if (other2 >= distance2) continue;
    distance2 = other2;
    best = &point;
  }
  return best;
}

TEST(NearestPoints, EqualsBruteForce) {
  std::mt19937_64 random(kPointSeed);
  std::normal_distribution<float> place(0.0F, 4.0F);
  for (const std::size_t count : {1U, 2U, 11U, 300U, 3000U}) {
    const std::vector<WallPoint> points = randomPoints(random, count);
    const NearestPoints tree(points);
    ASSERT_EQ(tree.size(), count);
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2f query(place(random), place(random));
      const float reach = i % 2 == 0 ? 0.2F : 100.0F;
      const WallPoint* expected = bruteForce(points, query, reach);
      const WallPoint* nearest = tree.nearest(query, reach);
      ASSERT_EQ(nearest != nullptr, expected != nullptr);
      if (expected == nullptr) continue;
      ++found;
      ASSERT_EQ(nearest->position, expected->position);
      ASSERT_EQ(nearest->normal, expected->normal);
    }
    EXPECT_GE(found, 1000);
  }
}

TEST(NearestPoints, HandlesNoPointsAndEqualPoints) {
  EXPECT_EQ(NearestPoints({}).nearest({0.0F, 0.0F}, 10.0F), nullptr);
  const Eigen::Vector2f place(1.0F, 2.0F);
  const NearestPoints same(std::vector<WallPoint>(100, {place, place}));
  ASSERT_NE(same.nearest({1.0F, 2.5F}, 0.6F), nullptr);
  EXPECT_EQ(same.nearest({1.0F, 2.5F}, 0.6F)->position, place);
  EXPECT_EQ(same.nearest({1.0F, 2.5F}, 0.4F), nullptr);
}

}  // namespace
}  // namespace kestrel
