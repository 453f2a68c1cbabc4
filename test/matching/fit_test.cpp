// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/fit.h"

#include <gtest/gtest.h>

#include "room.h"

namespace kestrel {
namespace {

constexpr double kScale_m = 0.1;
constexpr double kAlong = kAlongWeight;

/// Walls x = 2.02 m and optionally y = 3.02 m, each 2 m long.
Submap wallsAhead(bool and_left) {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  for (int i = -50; i <= 50; ++i) {
    const float along = 0.02F * static_cast<float>(i);
    scan.rays.push_back({Eigen::Vector2f::Zero(), {2.02F, along}, true});
  }
  for (int i = -50; i <= 50 && and_left; ++i) {
    const float along = 0.02F * static_cast<float>(i);
    scan.rays.push_back({Eigen::Vector2f::Zero(), {along, 3.02F}, true});
  }
  map.insert(scan, Pose2());
  return map;
}

TEST(FitOf, CountsPointsOnWallsAndMeasuresTheirConstraint) {
  const Points points = {{2.02F, 0.11F}, {2.05F, -0.53F}, {2.2F, 0.3F}, {0.3F, 3.02F}};
  const Fit corner = fitOf(wallsAhead(true), points, Pose2(), kScale_m);
  EXPECT_DOUBLE_EQ(corner.on_wall, 0.75);
  EXPECT_NEAR(leastConstraint(corner), 1.0 / 3.0 - kAlong / (1.0 + kAlong), 0.02);
  const Fit wall = fitOf(wallsAhead(false), points, Pose2(), kScale_m);
  EXPECT_DOUBLE_EQ(wall.on_wall, 0.5);
  EXPECT_NEAR(leastConstraint(wall), 0.0, 1e-3);
}

TEST(FitOf, ScoreDecreasesWithTheDistance) {
  const Submap map = wallsAhead(false);
  for (const double distance : {0.0, 0.03, 0.07, 0.1}) {
    const Points points = {Eigen::Vector2f(2.02F, 0.11F), Eigen::Vector2f(2.02F, -0.53F)};
    const Fit fit = fitOf(map, points, Pose2(-distance, 0.0, 0.0), kScale_m);
    const double ratio = distance / kScale_m;
    // The mean of a surfel may be half a cell away along the wall, which has the weight kAlong.
    EXPECT_NEAR(fit.score, 1.0 / (1.0 + ratio * ratio), 0.01) << distance;
    EXPECT_DOUBLE_EQ(fit.known, 1.0);
  }
}

TEST(FitOf, NormalsAreThoseOfTheWalls) {
  const Points ahead = {Eigen::Vector2f(2.02F, 0.1F), Eigen::Vector2f(2.02F, -0.1F)};
  const Eigen::Matrix2d one = fitOf(wallsAhead(false), ahead, Pose2(), kScale_m).normals;
  EXPECT_NEAR(one(0, 0), 1.0 / (1.0 + kAlong), 1e-3);
  EXPECT_NEAR(one(0, 1), 0.0, 1e-3);
  EXPECT_NEAR(one(1, 1), kAlong / (1.0 + kAlong), 1e-3);
  Points both = ahead;
  both.push_back({0.1F, 3.02F});
  both.push_back({-0.1F, 3.02F});
  const Eigen::Matrix2d two = fitOf(wallsAhead(true), both, Pose2(), kScale_m).normals;
  EXPECT_TRUE(two.isApprox(0.5 * Eigen::Matrix2d::Identity(), 1e-3)) << two;
}

TEST(FitOf, ResidualVarianceIsThatOfTheDistances) {
  const Points points(7, Eigen::Vector2f(2.02F, 0.1F));
  const Fit fit = fitOf(wallsAhead(false), points, Pose2(0.04, 0.0, 0.0), kScale_m);
  EXPECT_NEAR(fit.residual_variance, 0.04 * 0.04, 1e-4);
}

TEST(FitOf, IsZeroWithoutPointsInKnownSpace) {
  const Submap map = wallsAhead(false), empty{OccupancyGridConfig()};
  for (const Fit& fit : {fitOf(map, {}, Pose2(), kScale_m),
                         fitOf(map, {Eigen::Vector2f(1, 1)}, Pose2(300, 0, 0), kScale_m),
                         fitOf(empty, {Eigen::Vector2f(1, 1)}, Pose2(), kScale_m)}) {
    EXPECT_EQ(fit.score, 0.0);
    EXPECT_EQ(fit.known, 0.0);
    EXPECT_EQ(fit.residual_variance, 0.0);
    EXPECT_EQ(fit.normals, Eigen::Matrix2d::Zero());
  }
}

}  // namespace
}  // namespace kestrel
