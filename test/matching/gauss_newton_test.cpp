// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/gauss_newton.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

/// The gradient must be the derivative of the cost, as long as no point gets another surfel.
template <typename Linearize>
void expectGradient(const Pose2& pose, double step, double tolerance, Linearize linearize) {
  const NormalEquations at = linearize(pose);
  const std::array<Pose2, 3> forward = {Pose2(pose.x + step, pose.y, pose.yaw),
                                        Pose2(pose.x, pose.y + step, pose.yaw),
                                        Pose2(pose.x, pose.y, pose.yaw + step)};
  const std::array<Pose2, 3> backward = {Pose2(pose.x - step, pose.y, pose.yaw),
                                         Pose2(pose.x, pose.y - step, pose.yaw),
                                         Pose2(pose.x, pose.y, pose.yaw - step)};
  for (std::size_t i = 0; i < 3; ++i) {
    const double slope = (static_cast<double>(linearize(forward[i]).cost) -
                          static_cast<double>(linearize(backward[i]).cost)) /
                         (2.0 * step);
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(-static_cast<double>(at.gradient(row)), slope, tolerance * (1.0 + std::abs(slope)))
        << "component " << i;
  }
  EXPECT_TRUE(at.hessian.isApprox(at.hessian.transpose()));
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(at.hessian).eigenvalues()(0), -1e-3F);
}

TEST(GaussNewton, DistanceGradientIsTheDerivativeOfTheCost) {
  // One straight wall: all surfels are on the same line.
  Submap map{OccupancyGridConfig()};
  PlanarScan wall;
  for (int i = -100; i <= 100; ++i) {
    wall.rays.push_back(
        {Eigen::Vector2f::Zero(), Eigen::Vector2f(0.02F * static_cast<float>(i), 2.025F), true});
  }
  map.insert(wall, Pose2());
  Points points;
  for (int i = -9; i <= 9; ++i) points.push_back({0.1F * static_cast<float>(i) + 0.025F, 2.1F});
  for (const float scale : {0.3F, 0.05F}) {
    expectGradient(Pose2(0.0, -0.02, 0.01), 1e-4, 0.02, [&](const Pose2& pose) {
      return linearizeDistance(map.surface(), points, pose, scale);
    });
  }
}

TEST(GaussNewton, OccupancyGradientIsTheDerivativeOfTheCost) {
  const Submap map = room::map();
  // A few points inside the squares of the bilinear interpolation, away from their borders.
  const Points points = {{3.94F, 0.51F}, {3.96F, -1.02F}, {-0.52F, 2.94F}};
  for (int level = 0; level < OccupancyGrid::kLevels; ++level) {
    expectGradient(Pose2(0.004, 0.003, 0.0005), 2e-4, 0.02, [&](const Pose2& pose) {
      return linearizeOccupancy(map.grid(), level, points, pose, 0.5F);
    });
  }
}

TEST(GaussNewton, ConvergesToTheTruth) {
  const Submap map = room::map();
  const Pose2 truth(0.21, -0.13, 0.5);
  const Points points = hitsOf(room::scanFrom(truth));
  const Descent descent = descend(
      truth * Pose2(0.06, -0.05, 0.04), GaussNewtonConfig(), Eigen::Vector3f::Zero(),
      [&](const Pose2& pose) { return linearizeDistance(map.surface(), points, pose, 0.1F); });
  EXPECT_TRUE(descent.converged);
  EXPECT_NEAR(descent.pose.x, truth.x, 3e-3);
  EXPECT_NEAR(descent.pose.y, truth.y, 3e-3);
  EXPECT_NEAR(descent.pose.yaw, truth.yaw, 2e-3);
}

TEST(GaussNewton, StaysAtTheInitialGuessWithoutInformation) {
  const Submap map = room::map();
  const Pose2 initial_guess(100, -50, 1);
  const Points points = hitsOf(room::scanFrom(Pose2()));
  for (const Points& some : {points, Points()}) {
    const Descent descent = descend(
        initial_guess, GaussNewtonConfig(), Eigen::Vector3f::Zero(),
        [&](const Pose2& pose) { return linearizeDistance(map.surface(), some, pose, 0.1F); });
    EXPECT_EQ(descent.pose, initial_guess);
  }
}

}  // namespace
}  // namespace kestrel
