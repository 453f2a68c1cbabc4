// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/nearest_points.h"

#include <gtest/gtest.h>

#include <random>

namespace kestrel {
namespace {

constexpr std::uint64_t kPointSeed = 4;

template <int D>
using Vector = Eigen::Matrix<float, D, 1>;

template <int D>
Vector<D> randomPoint(std::mt19937_64& random, float sigma) {
  std::normal_distribution<float> place(0.0F, sigma);
  return Vector<D>::NullaryExpr([&] { return place(random); });
}

/// The nearest point within `reach_m` by brute force.
template <int D>
std::optional<std::size_t> bruteForce(const std::vector<Vector<D>>& points, const Vector<D>& place,
                                      float reach_m) {
  std::optional<std::size_t> best;
  float distance2 = reach_m * reach_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float other2 = (points[i] - place).squaredNorm();
    if (other2 >= distance2) continue;
    distance2 = other2;
    best = i;
  }
  return best;
}

template <int D>
void compareWithBruteForce() {
  std::mt19937_64 random(kPointSeed);
  for (const std::size_t count : {1U, 2U, 11U, 300U, 3000U}) {
    std::vector<Vector<D>> points(count);
    for (Vector<D>& point : points) point = randomPoint<D>(random, 3.0F);
    const NearestPoints<D> tree(points);
    ASSERT_EQ(tree.size(), count);
    int found = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vector<D> query = randomPoint<D>(random, 4.0F);
      const float reach = i % 2 == 0 ? 0.2F : 100.0F;
      const std::optional<std::size_t> nearest = tree.nearest(query, reach);
      ASSERT_EQ(nearest, bruteForce<D>(points, query, reach));
      if (nearest) ++found;
    }
    EXPECT_GE(found, 1000);
  }
}

TEST(NearestPoints, EqualsBruteForce) {
  compareWithBruteForce<2>();
  compareWithBruteForce<3>();
}

TEST(NearestPoints, HandlesNoPointsAndEqualPoints) {
  EXPECT_FALSE(NearestPoints<2>({}).nearest({0.0F, 0.0F}, 10.0F));
  EXPECT_FALSE(NearestPoints<3>({}).nearest({0.0F, 0.0F, 0.0F}, 10.0F));
  const NearestPoints<2> same(std::vector<Vector<2>>(100, {1.0F, 2.0F}));
  EXPECT_TRUE(same.nearest({1.0F, 2.5F}, 0.6F));
  EXPECT_FALSE(same.nearest({1.0F, 2.5F}, 0.4F));
}

}  // namespace
}  // namespace kestrel
