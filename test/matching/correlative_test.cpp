// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/correlative.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

Submap mapOf(const std::vector<room::Segment>& walls, double resolution_m) {
  OccupancyGridConfig config;
  config.resolution_m = resolution_m;
  Submap map{config};
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)}) {
    map.insert(room::scanFrom(pose, walls), pose);
  }
  return map;
}

/// The same pose, also among equally good ones, and the same derived values.
void expectEqual(const SearchResult& found, const SearchResult& expected, int i) {
  ASSERT_EQ(found.pose, expected.pose) << "window " << i;
  ASSERT_EQ(found.score, expected.score) << "window " << i;
  ASSERT_EQ(found.penalized_score, expected.penalized_score) << "window " << i;
  ASSERT_EQ(found.mean, expected.mean) << "window " << i;
  ASSERT_EQ(found.covariance, expected.covariance) << "window " << i;
}

/// Random scans of the room, also from far away and behind its walls, in windows of up to the given
/// size.
void compareWithBruteForce(double resolution_m, int windows, double most_m, double most_rad) {
  const Submap map = mapOf(room::walls(), resolution_m);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> position(-1.0, 1.0), angle(-kPi, kPi), share(-1.0, 1.0);
  for (int i = 0; i < windows; ++i) {
    const Pose2 truth(position(random), position(random), angle(random));
    const int beams = 1 + 9 * (i % 40);
    const Points points = hitsOf(room::scanFrom(truth, room::walls(), beams));
    const SearchWindow window{most_m * std::abs(share(random)), most_rad * std::abs(share(random))};
    const double away = i % 5 == 0 ? 8.0 : 1.0;  // partly or completely outside of the map
    const Pose2 center = truth * Pose2(away * most_m * share(random), most_m * share(random),
                                       most_rad * share(random));
    CorrelativeConfig config;
    if (i % 3 == 0) config.linear_preference = config.angular_preference = 0.0;
    if (i % 4 == 0) config.sigma_m = 0.03;
    const SearchResult found = searchWindow(map.surface(), points, center, window, config);
    expectEqual(found, searchWindowBruteForce(map.surface(), points, center, window, config), i);
    ASSERT_LE(std::abs(found.pose.x - center.x), window.linear_m + resolution_m + 1e-6);
    ASSERT_LE(std::abs(normalizeAngle(found.pose.yaw - center.yaw)), window.angular_rad + 0.05);
  }
}

TEST(Correlative, EqualsBruteForceOnRandomWindows) {
  compareWithBruteForce(0.05, 600, 0.6, 0.5);
  compareWithBruteForce(0.03, 200, 0.6, 0.5);
}

TEST(Correlative, EqualsBruteForceInLargeWindows) { compareWithBruteForce(0.05, 20, 4.0, 1.6); }

/// A few posts and points: many poses are equally good, and the first of them must be found.
TEST(Correlative, EqualsBruteForceIfManyPosesAreEqual) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> position(-1.5F, 1.5F);
  const auto randomPoints = [&](int count) {
    Points points;
    for (int i = 0; i < count; ++i) points.emplace_back(position(random), position(random));
    return points;
  };
  CorrelativeConfig config;
  config.linear_preference = config.angular_preference = 0.0;
  config.sigma_m = 0.01;
  for (int i = 0; i < 300; ++i) {
    PlanarScan posts;
    for (const Eigen::Vector2f& post : randomPoints(6)) posts.rays.push_back({post, post, true});
    Submap map{OccupancyGridConfig()};
    map.insert(posts, Pose2());
    const Points points = randomPoints(2 + i % 60);
    const SearchWindow window{0.05 * (i % 12), 0.05 * (i % 7)};
    expectEqual(searchWindow(map.surface(), points, Pose2(), window, config),
                searchWindowBruteForce(map.surface(), points, Pose2(), window, config), i);
  }
}

TEST(Correlative, FindsAPoseHalfAMeterAndTwentyDegreesAway) {
  const Submap map = mapOf(room::walls(), 0.05);
  const Pose2 truth(0.2, -0.3, 0.7);
  const Points points = hitsOf(room::scanFrom(truth));
  const SearchResult found = searchWindow(map.surface(), points, truth * Pose2(0.3, -0.35, 0.34),
                                          {0.6, 0.4}, CorrelativeConfig());
  EXPECT_NEAR(found.mean.x, truth.x, 0.04);
  EXPECT_NEAR(found.mean.y, truth.y, 0.04);
  EXPECT_NEAR(found.mean.yaw, truth.yaw, 0.02);
  EXPECT_GT(found.score, 0.8);
}

TEST(Correlative, CovarianceIsLargeAlongACorridor) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2(), room::corridor()), Pose2());
  map.insert(room::scanFrom(Pose2(), room::corridor()), Pose2(0.8, 0, 0));
  const Points points = hitsOf(room::scanFrom(Pose2(), room::corridor()));
  const SearchResult found =
      searchWindow(map.surface(), points, Pose2(0.4, 0, 0), {0.3, 0.1}, CorrelativeConfig());
  EXPECT_TRUE(found.covariance.isApprox(found.covariance.transpose()));
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(found.covariance).eigenvalues()(0), 0.0);
  EXPECT_GT(found.covariance(0, 0), 3.0 * found.covariance(1, 1));
}

TEST(Correlative, ReturnsTheCenterIfNothingMatches) {
  const Submap map = mapOf(room::walls(), 0.05);
  const Pose2 center(1, 2, 0.3);
  EXPECT_EQ(searchWindow(map.surface(), {}, center, {0.5, 0.5}, CorrelativeConfig()).pose, center);
  const SearchResult nowhere = searchWindow(map.surface(), {Eigen::Vector2f(1, 1)},
                                            Pose2(400, 400, 0), {0.0, 0.0}, CorrelativeConfig());
  EXPECT_EQ(nowhere.score, 0.0);
  EXPECT_TRUE(nowhere.covariance.allFinite());
}

}  // namespace
}  // namespace kestrel
