// SPDX-License-Identifier: BSD-3-Clause
// Tests of the exhaustive search at the borders of its window and with unusual input.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <chrono>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/correlative.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kCell = 0.05;

/// One surfel in the middle of cell (0, 0).
Submap onePost() {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  const Eigen::Vector2f middle(0.025F, 0.025F);
  scan.rays.push_back({middle, middle, true});
  map.insert(scan, Pose2());
  return map;
}

CorrelativeConfig withoutMotionPenalty() {
  CorrelativeConfig config;
  config.linear_preference = config.angular_preference = 0.0;
  return config;
}

SearchResult searchFor(const Submap& post, double offset_x, double offset_y, double window_m) {
  const Points points = {Eigen::Vector2f(0.025F, 0.025F)};
  return searchWindow(post.surface(), points, Pose2(offset_x, offset_y, 0.0), {window_m, 0.0},
                      withoutMotionPenalty());
}

TEST(SearchLimits, TheWindowIncludesItsBorder) {
  const Submap post = onePost();
  for (const double sign : {-1.0, 1.0}) {
    // Four cells away: found with a window of four cells, missed by one cell with a window of
    // three.
    const SearchResult found = searchFor(post, sign * 4 * kCell, -sign * 4 * kCell, 4 * kCell);
    EXPECT_NEAR(found.pose.x, 0.0, 1e-6);
    EXPECT_NEAR(found.pose.y, 0.0, 1e-6);
    EXPECT_DOUBLE_EQ(found.score, 1.0);
    const SearchResult shorter = searchFor(post, sign * 4 * kCell, 0.0, 3 * kCell);
    EXPECT_NEAR(shorter.pose.x, sign * kCell, 1e-6);
    // The likelihood at a distance of one cell, in steps of 1/255: exp(-0.05² / (2 * 0.1²)).
    EXPECT_NEAR(shorter.score, std::exp(-0.125), 0.5 / 255.0 + 1e-6);
  }
}

TEST(SearchLimits, AnEmptyWindowReturnsTheCenter) {
  const SearchResult found = searchFor(onePost(), 0.1, 0.0, 0.0);
  EXPECT_EQ(found.pose, Pose2(0.1, 0.0, 0.0));
  EXPECT_NEAR(found.score, std::exp(-0.5), 0.5 / 255.0 + 1e-6);
}

TEST(SearchLimits, SubtractsThePenaltyOfTheMotion) {
  CorrelativeConfig config;
  config.linear_preference = 0.3;
  const Points points = {Eigen::Vector2f(0.025F, 0.025F)};
  const SearchResult found =
      searchWindow(onePost().surface(), points, Pose2(0.15, 0.2, 0.0), {0.3, 0.0}, config);
  // The motion to the post is 0.25 m; its penalty is smaller than the gain.
  EXPECT_NEAR(found.pose.distance(), 0.0, 1e-6);
  EXPECT_NEAR(found.penalized_score, 1.0 - 0.3 * 0.25, 1e-6);
}

TEST(SearchLimits, FindsThePoseInAWindowOfTenMetersAndAllYaws) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2()), Pose2());
  const Pose2 truth(0.3, -0.2, 2.2);
  const Points points = hitsOf(room::scanFrom(truth, room::walls(), 180));
  const SearchResult found =
      searchWindow(map.surface(), points, Pose2(6.0, 5.0, -0.5), {10.0, kPi}, CorrelativeConfig());
  EXPECT_NEAR(found.mean.x, truth.x, 0.05);
  EXPECT_NEAR(found.mean.y, truth.y, 0.05);
  EXPECT_NEAR(normalizeAngle(found.mean.yaw - truth.yaw), 0.0, 0.02);
}

TEST(SearchLimits, BruteForceReturnsTheCenterWithoutPoints) {
  const Submap post = onePost();
  const Pose2 center(1.0, 2.0, 0.3);
  const SearchResult found =
      searchWindowBruteForce(post.surface(), {}, center, {0.2, 0.2}, CorrelativeConfig());
  EXPECT_EQ(found.pose, center);
  EXPECT_EQ(found.score, 0.0);
  EXPECT_TRUE(found.covariance.allFinite());
}

TEST(SearchLimits, IgnoresFarPoints) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2()), Pose2());
  const Pose2 truth(0.2, 0.1, 0.1);
  Points points = hitsOf(room::scanFrom(truth));
  const auto start = std::chrono::steady_clock::now();
  // An image that covers them would have 400 000 × 400 000 cells.
  for (const float range : {200.0F, 1000.0F, 9999.0F}) points.push_back({range, 0.5F * range});
  const SearchWindow window{0.3, 0.2};
  const SearchResult found =
      searchWindow(map.surface(), points, Pose2(), window, CorrelativeConfig());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 5.0);
  EXPECT_NEAR(found.mean.x, truth.x, 0.04);
  EXPECT_NEAR(found.mean.y, truth.y, 0.04);
  EXPECT_NEAR(found.mean.yaw, truth.yaw, 0.02);
  const SearchResult expected =
      searchWindowBruteForce(map.surface(), points, Pose2(), window, CorrelativeConfig());
  EXPECT_DOUBLE_EQ(found.penalized_score, expected.penalized_score);
}

TEST(SearchLimits, ReturnsTheCenterIfAllPointsAreFar) {
  const Points points(3, Eigen::Vector2f(5000.0F, 0.0F));
  const SearchResult found =
      searchWindow(onePost().surface(), points, Pose2(), {0.3, 0.2}, CorrelativeConfig());
  EXPECT_EQ(found.pose, Pose2());
  EXPECT_EQ(found.score, 0.0);
  EXPECT_TRUE(found.covariance.allFinite());
}

TEST(SearchLimits, CovarianceIsSymmetricAndPositiveSemidefinite) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2()), Pose2());
  for (int i = 0; i < 40; ++i) {
    const Pose2 truth(0.05 * i - 1.0, 0.03 * i - 0.6, 0.3 * i);
    const Points points = hitsOf(room::scanFrom(truth, room::walls(), 3 + 5 * i));
    const Eigen::Matrix3d covariance =
        searchWindow(map.surface(), points, truth, {0.2, 0.1}, CorrelativeConfig()).covariance;
    ASSERT_TRUE(covariance.isApprox(covariance.transpose(), 1e-12)) << i;
    ASSERT_GE(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()(0), -1e-12);
  }
}

}  // namespace
}  // namespace kestrel
