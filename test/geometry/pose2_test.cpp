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

TEST(Pose2, IsTheIdentityByDefault) {
  EXPECT_EQ(Pose2(), Pose2(0.0, 0.0, 0.0));
  for (const Pose2& pose : samplePoses()) {
    expectNear(pose * Pose2(), pose);
    expectNear(Pose2() * pose, pose);
  }
}

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

TEST(Pose2, InverseUndoes) {
  for (const Pose2& pose : samplePoses()) {
    expectNear(pose * pose.inverse(), Pose2());
    expectNear(pose.inverse() * pose, Pose2());
    expectNear(pose.inverse().inverse(), pose);
  }
}

TEST(Pose2, IsAssociative) {
  const std::vector<Pose2> poses = samplePoses();
  for (std::size_t i = 0; i + 2 < poses.size(); ++i) {
    const Pose2 &a = poses[i], &b = poses[i + 1], &c = poses[i + 2];
    expectNear((a * b) * c, a * (b * c));
    expectNear((a * b).inverse(), b.inverse() * a.inverse());
  }
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

}  // namespace
}  // namespace kestrel
