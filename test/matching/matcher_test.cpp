// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/matcher.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

MatchResult match(const std::string& method, const Submap& map, const Points& points,
                  const Pose2& initial_guess) {
  MatcherConfig config;
  config.method = method;
  return makeMatcher(config)->match(map, {points, initial_guess, {initial_guess}, false, 1.0});
}

void expectCovariance(const Eigen::Matrix3d& covariance) {
  EXPECT_TRUE(covariance.allFinite());
  EXPECT_TRUE(covariance.isApprox(covariance.transpose()));
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues()(0), 0.0);
}

class EveryMatcher : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryMatcher, FindsAKnownPose) {
  const Submap map = room::map();
  for (const Pose2& truth : {Pose2(0.2, 0.1, 0.3), Pose2(-0.8, 0.6, -2.0), Pose2(0.9, -0.7, 3.1)}) {
    const Points points = hitsOf(room::scanFrom(truth));
    const MatchResult result = match(GetParam(), map, points, truth * Pose2(0.06, -0.04, 0.04));
    // Votes cannot resolve the position of a wall within its cells, and the walls of the room are
    // parallel to the cells.
    const double tolerance = GetParam() == "progressive" ? 0.05 : 0.03;
    EXPECT_NEAR(result.pose.x, truth.x, tolerance);
    EXPECT_NEAR(result.pose.y, truth.y, tolerance);
    EXPECT_NEAR(normalizeAngle(result.pose.yaw - truth.yaw), 0.0, 0.012);
    EXPECT_TRUE(result.converged);
    EXPECT_GT(result.score, 0.8);
    EXPECT_GT(result.known, 0.9);
    EXPECT_FALSE(result.degenerate);
    expectCovariance(result.covariance);
  }
}

TEST_P(EveryMatcher, HasALowScoreIfNothingFits) {
  const Submap map = room::map();
  Points points;  // a circle in free space
  for (int i = 0; i < 90; ++i) {
    points.push_back(
        {std::cos(static_cast<float>(i) * 0.07F), std::sin(static_cast<float>(i) * 0.07F)});
  }
  const MatchResult result = match(GetParam(), map, points, Pose2());
  EXPECT_LT(result.score, 0.5);
  EXPECT_TRUE(result.pose.isFinite());
  expectCovariance(result.covariance);
}

TEST_P(EveryMatcher, SurvivesAnEmptyMapAndOnePoint) {
  const Submap empty{OccupancyGridConfig()};
  const MatchResult nothing = match(GetParam(), empty, {Eigen::Vector2f(1, 1)}, Pose2(1, 2, 3));
  EXPECT_EQ(nothing.score, 0.0);
  EXPECT_TRUE(nothing.pose.isFinite());
  EXPECT_TRUE(nothing.covariance.allFinite());
  const MatchResult one = match(GetParam(), room::map(), {Eigen::Vector2f(4, 0)}, Pose2());
  EXPECT_TRUE(one.pose.isFinite());
  EXPECT_TRUE(one.covariance.allFinite());
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMatcher,
                         ::testing::Values("gauss_newton", "correlative", "progressive", "icp",
                                           "hybrid"));

TEST(HybridMatcher, SearchesIfTheInitialGuessIsFarOff) {
  const Submap map = room::map();
  const Pose2 truth(0.3, 0.2, 0.4);
  const Points points = hitsOf(room::scanFrom(truth));
  const MatchResult near = match("hybrid", map, points, truth * Pose2(0.02, 0.01, 0.01));
  EXPECT_FALSE(near.searched);
  const MatchResult far = match("hybrid", map, points, truth * Pose2(0.6, -0.55, 1.1));
  EXPECT_TRUE(far.searched);
  EXPECT_NEAR((truth.inverse() * far.pose).distance(), 0.0, 0.01);
  EXPECT_NEAR(normalizeAngle(far.pose.yaw - truth.yaw), 0.0, 0.005);
}

TEST(HybridMatcher, AGuessThatIsGivenTwiceChangesNothing) {
  const Submap map = room::map();
  const Points points = hitsOf(room::scanFrom(Pose2(0.2, 0.1, 0.3)));
  const Pose2 far(0.9, -0.5, 0.8), farther(-1.2, 0.3, -0.4);
  MatchRequest once{points, far, {far, farther}};
  MatchRequest twice{points, far, {far, far, farther, far, farther}};
  const auto matcher = makeMatcher(MatcherConfig());
  const MatchResult a = matcher->match(map, once), b = matcher->match(map, twice);
  EXPECT_EQ(a.pose.x, b.pose.x);
  EXPECT_EQ(a.pose.y, b.pose.y);
  EXPECT_EQ(a.pose.yaw, b.pose.yaw);
  EXPECT_EQ(a.score, b.score);
}

TEST(HybridMatcher, FindsAReversedPoseIfAllYawsAreSearched) {
  // No two of the four walls are parallel, so the view is different at every yaw.
  const std::vector<room::Segment> walls = {
      {-4, -3, 4, -2}, {4, -2, 2, 3}, {2, 3, -1, 2}, {-1, 2, -4, -3}};
  Submap map{OccupancyGridConfig()};
  map.insert(room::scanFrom(Pose2(), walls), Pose2());
  const Pose2 truth(0.1, -0.1, 0.4), initial_guess = truth * Pose2(0.1, 0.1, 2.8);
  const Points points = hitsOf(room::scanFrom(truth, walls));
  const MatchResult result =
      makeMatcher(MatcherConfig())->match(map, {points, initial_guess, {initial_guess}, true, 1.0});
  EXPECT_TRUE(result.searched);
  EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.02);
  EXPECT_NEAR(normalizeAngle(result.pose.yaw - truth.yaw), 0.0, 0.01);
}

/// The match of a scan from the origin of the room, 2 m away from the first guess.
MatchResult matchTurnedBack(const Points& points, double turned_back_m) {
  const Pose2 guess(2.0, 0.0, 0.0);
  MatchRequest request{points, guess, {guess}};
  request.wide = true;
  request.turned_back_m = turned_back_m;
  return makeMatcher(MatcherConfig())->match(room::map(), request);
}

TEST(HybridMatcher, FindsAVehicleThatTurnedBack) {
  const Points points = hitsOf(room::scanFrom(Pose2()));
  EXPECT_NEAR(matchTurnedBack(points, 2.0).pose.distance(), 0.0, 0.03);
  EXPECT_GT(matchTurnedBack(points, 0.0).pose.distance(), 0.5);
}

TEST(HybridMatcher, WhereAVehicleTurnedBackTheScanMustFitWell) {
  // Every third wall of the scan is another one.
  Points points = hitsOf(room::scanFrom(Pose2()));
  for (std::size_t i = 0; i < points.size(); i += 3) points[i] *= 0.5F;
  EXPECT_EQ(matchTurnedBack(points, 2.0).pose.x, matchTurnedBack(points, 0.0).pose.x);
}

TEST(HybridMatcher, NearThePoseItIsNoAdvantageToBeInUnknownSpace) {
  // Every third wall of the scan is another one. Outside of the room one wall fits perfectly, and
  // the rest of the scan is in unknown space.
  Points points = hitsOf(room::scanFrom(Pose2()));
  for (std::size_t i = 0; i < points.size(); i += 3) points[i] *= 0.5F;
  MatchRequest request{points, Pose2(), {Pose2(), Pose2(8.0, 0.0, 0.0)}};
  request.near = true;
  MatcherConfig config;
  config.correlative.linear_preference = 0.0;
  const MatchResult result = makeMatcher(config)->match(room::map(), request);
  EXPECT_NEAR(result.pose.distance(), 0.0, 0.03);
}

TEST(HybridMatcher, ACorridorIsUnobservableAlongItself) {
  // Dense enough that distant neighboring hits still give the direction of the wall.
  const PlanarScan scan = room::scanFrom(Pose2(), room::corridor(), 1440);
  Submap map{OccupancyGridConfig()};
  for (int i = 0; i < 4; ++i) map.insert(scan, Pose2(0.5 * i, 0, 0));
  const Points points = hitsOf(scan);
  const MatchResult result = match("hybrid", map, points, Pose2(0.7, 0.05, 0.02));
  EXPECT_TRUE(result.degenerate);
  EXPECT_NEAR(std::abs(result.degenerate_direction.x()), 1.0, 0.01);
  EXPECT_GT(result.covariance(0, 0), 0.1);
  EXPECT_LT(result.covariance(1, 1), 0.01);
  EXPECT_NEAR(result.pose.y, 0.0, 0.01);
  EXPECT_NEAR(result.pose.yaw, 0.0, 0.005);
  EXPECT_NEAR(result.pose.x, 0.7, 0.15);  // only small corrections along the unobservable direction
}

TEST(Fit, CountsOnlyPointsInKnownSpace) {
  Submap map{OccupancyGridConfig()};
  PlanarScan scan;
  for (int i = -20; i <= 20; ++i) {
    scan.rays.push_back(
        {Eigen::Vector2f::Zero(), Eigen::Vector2f(2.02F, 0.05F * static_cast<float>(i)), true});
  }
  map.insert(scan, Pose2());
  const Points on_wall(10, Eigen::Vector2f(2.02F, 0.0F));
  EXPECT_NEAR(fitOf(map, on_wall, Pose2(), 0.1).score, 1.0, 1e-3);
  Points points = on_wall;
  points.resize(20, Eigen::Vector2f(-5.0F, 0.0F));  // unknown
  EXPECT_NEAR(fitOf(map, points, Pose2(), 0.1).score, 1.0, 1e-3);
  EXPECT_NEAR(fitOf(map, points, Pose2(), 0.1).known, 0.5, 1e-9);
  points = on_wall;
  points.resize(20, Eigen::Vector2f(1.0F, 0.0F));  // free
  EXPECT_NEAR(fitOf(map, points, Pose2(), 0.1).score, 0.5, 1e-3);
  EXPECT_NEAR(fitOf(map, points, Pose2(), 0.1).known, 1.0, 1e-9);
  // A point at the distance `scale_m` from the wall fits by half.
  EXPECT_NEAR(fitOf(map, {Eigen::Vector2f(1.92F, 0.0F)}, Pose2(), 0.1).score, 0.5, 0.01);
}

TEST(MakeMatcher, ReportsAnUnknownMethod) {
  MatcherConfig config;
  config.method = "magic";
  try {
    makeMatcher(config);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("magic"), std::string::npos);
  }
}

TEST(MakeMatcher, KnowsEveryName) {
  MatcherConfig config;
  EXPECT_NE(std::find(matcherNames().begin(), matcherNames().end(), config.method),
            matcherNames().end());
  for (const std::string& name : matcherNames()) {
    config.method = name;
    EXPECT_NE(makeMatcher(config), nullptr) << name;
  }
}

}  // namespace
}  // namespace kestrel
