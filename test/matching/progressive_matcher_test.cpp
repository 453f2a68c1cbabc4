// SPDX-License-Identifier: BSD-3-Clause
// Tests of the progressive matcher [Xie 2010] as a whole. progressive_test.cpp tests its parts.

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

/// Pose of the room in the map. It is rotated, so that its walls cross the cells at many positions.
const Pose2 kTurned(0.013, 0.021, 0.3);

TEST(ProgressiveMatcher, ReportsThatTheRefinementStopped) {
  Submap map{OccupancyGridConfig()};
  PlanarScan wall;  // in the 5 cm cells from 2.0 to 2.05 m
  Points points;    // in the same 20 cm cell as the wall, but in another 10 cm cell
  for (int i = -40; i < 40; ++i) {
    const float x = 0.05F * static_cast<float>(i) + 0.025F;
    wall.rays.push_back({Eigen::Vector2f::Zero(), Eigen::Vector2f(x, 2.02F), true});
    points.emplace_back(0.5F * x, 2.17F);
  }
  map.insert(wall, Pose2());
  MatcherConfig config;
  config.method = "progressive";
  config.search_score = 0.0;
  config.progressive.slack_cells = 0.0;
  config.progressive.min_sigma_rad = 0.001;
  const MatchResult result =
      makeMatcher(config)->match(map, {points, Pose2(), {Pose2()}, false, 1.0});
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.pose, Pose2());
  EXPECT_EQ(result.iterations, 1);
  EXPECT_FALSE(result.searched);
  for (const StageEstimate& stage : result.stages) EXPECT_EQ(stage.pose, Pose2());
}

TEST(ProgressiveMatcher, TheSeedDeterminesTheResult) {
  const Submap map = room::map();
  const Pose2 truth(0.2, 0.1, 0.3), initial_guess = truth * Pose2(0.06, -0.04, 0.04);
  const Points points = hitsOf(room::scanFrom(truth));
  const auto matchWith = [&](const Matcher& matcher) {
    return matcher.match(map, {points, initial_guess, {initial_guess}, false, 1.0});
  };
  MatcherConfig config;
  config.method = "progressive";
  const std::unique_ptr<Matcher> matcher = makeMatcher(config);
  const MatchResult first = matchWith(*matcher), again = matchWith(*matcher),
                    other_matcher = matchWith(*makeMatcher(config));
  for (const MatchResult& same : {again, other_matcher}) {
    EXPECT_EQ(same.pose, first.pose);
    EXPECT_EQ(same.covariance, first.covariance);
    EXPECT_EQ(same.score, first.score);
  }
  config.progressive.seed = 2;
  EXPECT_FALSE(matchWith(*makeMatcher(config)).pose == first.pose);
}

TEST(ProgressiveMatcher, SearchesIfTheInitialGuessIsFarOff) {
  const Submap map = room::map(kTurned);
  const Pose2 in_room(0.3, 0.2, 0.4), truth = kTurned * in_room;
  const Pose2 initial_guess = truth * Pose2(0.5, -0.4, 0.7);
  const Points points = hitsOf(room::scanFrom(in_room));
  MatcherConfig config;
  config.method = "progressive";
  const MatchResult result =
      makeMatcher(config)->match(map, {points, initial_guess, {initial_guess}, false, 1.0});
  EXPECT_TRUE(result.searched);
  EXPECT_LT((truth.inverse() * result.pose).distance(), 0.015);
  EXPECT_NEAR(normalizeAngle(result.pose.yaw - truth.yaw), 0.0, 0.01);
}

/// Mean of e' P^-1 e over many matches with 1 cm of range noise. It is 3 for a correct covariance.
TEST(ProgressiveMatcher, CovarianceAgreesWithTheErrors) {
  MatcherConfig config;
  config.method = "progressive";
  const std::unique_ptr<Matcher> matcher = makeMatcher(config);
  const Submap map = room::map(kTurned);
  Random random(5);
  constexpr int kRuns = 200;
  double sum = 0.0;
  for (int i = 0; i < kRuns; ++i) {
    const Pose2 in_room(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5),
                        random.uniform(-kPi, kPi));
    const Pose2 truth = kTurned * in_room;
    Points points = hitsOf(room::scanFrom(in_room));
    for (Eigen::Vector2f& p : points) {
      p += 0.01F * static_cast<float>(random.gaussian()) * p.normalized();
    }
    const Pose2 initial_guess =
        truth * Pose2(0.05 * random.gaussian(), 0.05 * random.gaussian(), 0.02 * random.gaussian());
    const MatchResult result =
        matcher->match(map, {points, initial_guess, {initial_guess}, false, 1.0});
    const Eigen::Vector3d error(result.pose.x - truth.x, result.pose.y - truth.y,
                                normalizeAngle(result.pose.yaw - truth.yaw));
    sum += error.dot(result.covariance.inverse() * error);
  }
  EXPECT_GT(sum / kRuns, 1.0);
  EXPECT_LT(sum / kRuns, 4.0);
}

}  // namespace
}  // namespace kestrel
