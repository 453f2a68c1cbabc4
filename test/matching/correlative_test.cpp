#include "kestrel_slam/matching/correlative.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "kestrel_slam/map/submap.h"
#include "room.h"

namespace kestrel_slam {
namespace {

Submap mapOf(const std::vector<room::Segment>& walls) {
  Submap map{OccupancyGridConfig()};
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)}) {
    map.insert(room::scanFrom(pose, walls), pose);
  }
  return map;
}

TEST(Correlative, EqualsBruteForceOnRandomWindows) {
  const Submap map = mapOf(room::walls());
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> position(-1.0, 1.0), angle(-kPi, kPi), size(0.0, 0.45);
  for (int i = 0; i < 150; ++i) {
    const Pose2 truth(position(random), position(random), angle(random));
    const Points points = room::hitsOf(room::scanFrom(truth, room::walls(), 45));
    const Pose2 center = truth * Pose2(size(random) - 0.2, size(random) - 0.2, size(random) - 0.2);
    const SearchWindow window{size(random), 0.5 * size(random)};
    CorrelativeConfig config;
    if (i % 3 == 0) config.linear_preference = config.angular_preference = 0.0;
    const SearchResult found = searchWindow(map.surface(), points, center, window, config);
    const SearchResult expected =
        searchWindowBruteForce(map.surface(), points, center, window, config);
    ASSERT_DOUBLE_EQ(found.preferred, expected.preferred) << "window " << i;
    ASSERT_LE(std::abs(found.pose.x - center.x), window.linear_m + 0.0501);
    ASSERT_LE(std::abs(normalizeAngle(found.pose.theta - center.theta)), window.angular_rad + 0.05);
  }
}

TEST(Correlative, FindsAPoseHalfAMetreAndTwentyDegreesAway) {
  const Submap map = mapOf(room::walls());
  const Pose2 truth(0.2, -0.3, 0.7);
  const Points points = room::hitsOf(room::scanFrom(truth));
  const SearchResult found = searchWindow(map.surface(), points, truth * Pose2(0.3, -0.35, 0.34),
                                          {0.6, 0.4}, CorrelativeConfig());
  EXPECT_NEAR(found.mean.x, truth.x, 0.04);
  EXPECT_NEAR(found.mean.y, truth.y, 0.04);
  EXPECT_NEAR(found.mean.theta, truth.theta, 0.02);
  EXPECT_GT(found.score, 0.8);
}

TEST(Correlative, CovarianceIsLargeAlongACorridor) {
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2(), room::corridor()), Pose2());
  map.insert(room::scanFrom(Pose2(), room::corridor()), Pose2(0.8, 0, 0));
  const Points points = room::hitsOf(room::scanFrom(Pose2(), room::corridor()));
  const SearchResult found =
      searchWindow(map.surface(), points, Pose2(0.4, 0, 0), {0.3, 0.1}, CorrelativeConfig());
  EXPECT_TRUE(found.covariance.isApprox(found.covariance.transpose()));
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(found.covariance).eigenvalues()(0), 0.0);
  EXPECT_GT(found.covariance(0, 0), 3.0 * found.covariance(1, 1));
}

TEST(Correlative, NothingToMatchGivesTheCentre) {
  const Submap map = mapOf(room::walls());
  const Pose2 center(1, 2, 0.3);
  EXPECT_EQ(searchWindow(map.surface(), {}, center, {0.5, 0.5}, CorrelativeConfig()).pose, center);
  const SearchResult nowhere = searchWindow(map.surface(), {Eigen::Vector2f(1, 1)},
                                            Pose2(400, 400, 0), {0.0, 0.0}, CorrelativeConfig());
  EXPECT_EQ(nowhere.score, 0.0);
  EXPECT_TRUE(nowhere.covariance.allFinite());
}

}  // namespace
}  // namespace kestrel_slam
