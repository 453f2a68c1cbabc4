// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/rigid_alignment.h"

#include <gtest/gtest.h>

#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Points = std::vector<Eigen::Vector2d>;

Points randomPoints(Random& random, std::size_t count) {
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(-10.0, 10.0);
    points.emplace_back(x, random.uniform(-10.0, 10.0));
  }
  return points;
}

double squaresOf(const Pose2& to_T_from, const Points& from, const Points& to) {
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) sum += (to_T_from * from[i] - to[i]).squaredNorm();
  return sum;
}

TEST(RigidAlignment, FindsTheMotionOfExactPoints) {
  Random random(1);
  for (const double yaw : {0.0, 1e-10, 1e-5, 1.0, -2.0, kPi - 1e-10, kPi}) {
    for (const std::size_t count : {2U, 3U, 100U}) {
      const Pose2 truth(random.uniform(-50.0, 50.0), 3.0, yaw);
      const Points from = randomPoints(random, count);
      Points to;
      for (const Eigen::Vector2d& p : from) to.push_back(truth * p);
      EXPECT_LT(offsetBetween(truth, alignPoints(from, to)).norm(), 1e-12);
    }
  }
}

TEST(RigidAlignment, HasTheLeastSquares) {
  Random random(2);
  for (int run = 0; run < 20; ++run) {
    const Points from = randomPoints(random, 30), to = randomPoints(random, 30);
    const Pose2 found = alignPoints(from, to);
    const double least = squaresOf(found, from, to);
    for (int i = 0; i < 100; ++i) {
      const double size = i % 2 == 0 ? 1e-3 : 1.0;
      const Eigen::Vector3d t(random.gaussian(), random.gaussian(), random.gaussian());
      EXPECT_GT(squaresOf(found * Pose2::exp(size * t), from, to), least);
    }
  }
}

TEST(RigidAlignment, WithoutSpreadHasTheDefaultYaw) {
  const Points from(5, {1.0, 0.0}), to(5, {0.0, 4.0});
  EXPECT_EQ(alignPoints(from, to), Pose2(-1.0, 4.0, 0.0));
  const Pose2 turned = alignPoints({from[0]}, {to[0]}, kPi / 2.0);
  EXPECT_EQ(turned.yaw, kPi / 2.0);
  EXPECT_LT((turned * from[0] - to[0]).norm(), 1e-15);
}

}  // namespace
}  // namespace kestrel
