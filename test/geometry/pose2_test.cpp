// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/pose2.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace kestrel {
namespace {

Eigen::Isometry2d toEigen(const Pose2& pose) {
  Eigen::Isometry2d result = Eigen::Isometry2d::Identity();
  result.translate(pose.translation());
  result.rotate(Eigen::Rotation2Dd(pose.yaw));
  return result;
}

/// Edge values of the angle, and as many random poses.
std::vector<Pose2> samplePoses() {
  std::vector<Pose2> poses;
  for (const double yaw : {0.0, kPi, -kPi, kPi / 2.0, 1e-10, -1e-10, kPi - 1e-10, -kPi + 1e-10}) {
    poses.emplace_back(0.0, 0.0, yaw);
    poses.emplace_back(1e-10, -3.0, yaw);
    poses.emplace_back(-1000.0, 2000.0, yaw);
  }
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> position(-50.0, 50.0);
  std::uniform_real_distribution<double> angle(-10.0, 10.0);
  for (int i = 0; i < 24; ++i)
    poses.emplace_back(position(random), position(random), angle(random));
  return poses;
}

void expectNear(const Pose2& a, const Pose2& b) {
  constexpr double kTolerance = 1e-9;  // rounding at the largest coordinates, 2000 m
  EXPECT_NEAR(a.x, b.x, kTolerance);
  EXPECT_NEAR(a.y, b.y, kTolerance);
  EXPECT_NEAR(normalizeAngle(a.yaw - b.yaw), 0.0, kTolerance);
}

TEST(Pose2, IsTheIdentityByDefault) { EXPECT_EQ(Pose2(), Pose2(0.0, 0.0, 0.0)); }

TEST(Pose2, WrapsItsAngle) {
  EXPECT_EQ(Pose2(0.0, 0.0, -kPi).yaw, kPi);
  EXPECT_NEAR(Pose2(0.0, 0.0, 4.0).yaw, 4.0 - 2.0 * kPi, 1e-15);
  for (const Pose2& a : samplePoses()) {
    for (const Pose2& b : samplePoses()) {
      EXPECT_GT((a * b).yaw, -kPi);
      EXPECT_LE((a * b).yaw, kPi);
    }
  }
}

TEST(Pose2, ComposesAQuarterTurn) {
  const Pose2 moved = Pose2(1.0, 2.0, kPi / 2.0) * Pose2(3.0, 0.0, kPi / 2.0);
  expectNear(moved, Pose2(1.0, 5.0, kPi));
  EXPECT_TRUE((Pose2(1.0, 2.0, kPi / 2.0) * Eigen::Vector2d(0.0, 1.0))
                  .isApprox(Eigen::Vector2d(0.0, 2.0), 1e-15));
}

TEST(Pose2, AgreesWithEigen) {
  const Eigen::Vector2d point(0.7, -1.3);
  for (const Pose2& a : samplePoses()) {
    EXPECT_TRUE(toEigen(a.inverse()).isApprox(toEigen(a).inverse(), 1e-9));
    EXPECT_LT(((a * point) - (toEigen(a) * point)).norm(), 1e-9);
    for (const Pose2& b : samplePoses()) {
      EXPECT_TRUE(toEigen(a * b).isApprox(toEigen(a) * toEigen(b), 1e-9));
    }
  }
}

TEST(Pose2, KnowsItsDistanceAndWhetherItIsFinite) {
  EXPECT_EQ(Pose2(3.0, -4.0, 1.0).distance(), 5.0);
  EXPECT_TRUE(Pose2(3.0, -4.0, 1.0).isFinite());
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(Pose2(inf, 0.0, 0.0).isFinite());
  EXPECT_FALSE(Pose2(0.0, std::nan(""), 0.0).isFinite());
  EXPECT_FALSE(Pose2(0.0, 0.0, inf).isFinite());
}

TEST(Pose2Exp, FollowsAnArc) {
  // A quarter of a circle to the left with a radius of 2 m.
  const Pose2 end = Pose2::exp({kPi, 0.0, kPi / 2.0});
  EXPECT_NEAR(end.x, 2.0, 1e-15);
  EXPECT_NEAR(end.y, 2.0, 1e-15);
  EXPECT_EQ(end.yaw, kPi / 2.0);
}

TEST(Pose2Exp, WrapsTheYaw) {
  EXPECT_EQ(Pose2::exp({0.0, 0.0, -kPi}).yaw, kPi);
  EXPECT_NEAR(Pose2::exp({1.0, 0.0, 2.0 * kPi}).x, 0.0, 1e-15);  // a full circle
}

TEST(Pose2Offset, IsAlongTheAxesOfTheOuterFrame) {
  const Pose2 pose(1.0, 2.0, kPi / 2.0);
  EXPECT_EQ(addOffset(pose, {1.0, 0.0, 0.0}), Pose2(2.0, 2.0, kPi / 2.0));
  for (const Pose2& sample : samplePoses()) {
    const Eigen::Vector3d offset(sample.x, sample.y, sample.yaw);
    EXPECT_LT((offsetBetween(pose, addOffset(pose, offset)) - offset).norm(), 1e-12);
  }
}

TEST(Pose2Interpolation, EndsAtBothPoses) {
  const std::vector<Pose2> poses = samplePoses();
  for (std::size_t i = 0; i + 1 < poses.size(); ++i) {
    EXPECT_EQ(interpolate(poses[i], poses[i + 1], 0.0), poses[i]);
    EXPECT_LT(offsetBetween(interpolate(poses[i], poses[i + 1], 1.0), poses[i + 1]).norm(), 1e-14);
    EXPECT_LT(offsetBetween(interpolate(poses[i], poses[i], 0.3), poses[i]).norm(), 1e-13);
  }
}

TEST(Pose2Interpolation, TurnsTheShorterWay) {
  const Pose2 result = interpolate(Pose2(0.0, 0.0, 3.0), Pose2(4.0, 8.0, -3.0), 0.25);
  EXPECT_DOUBLE_EQ(result.x, 1.0);
  EXPECT_DOUBLE_EQ(result.y, 2.0);
  EXPECT_NEAR(result.yaw, 3.0 + 0.25 * (2.0 * kPi - 6.0), 1e-15);
}

}  // namespace
}  // namespace kestrel
