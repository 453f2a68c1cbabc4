// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/progressive.h"

#include <gtest/gtest.h>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kBeams = 200.0;

/// A wall along x at y = 2.02 m, seen from the origin. It is in the 5 cm cells from 2.0 to 2.05 m.
OccupancyGrid wall() {
  PlanarScan scan;
  for (int i = -40; i < 40; ++i) {
    scan.rays.push_back({Eigen::Vector2f::Zero(),
                         Eigen::Vector2f(0.05F * static_cast<float>(i) + 0.025F, 2.02F), true});
  }
  OccupancyGrid grid{OccupancyGridConfig()};
  grid.insert(scan, Pose2());
  return grid;
}

/// End points on a line at `y`, not near the ends of the wall.
Points lineAt(float y) {
  Points points;
  for (int i = -40; i <= 40; ++i) points.emplace_back(0.025F * static_cast<float>(i), y);
  return points;
}

/// The voting likelihood [Xie 2010, eq. 21], computed directly.
double countedVotes(const OccupancyGrid& grid, int level, const Points& points, const Pose2& pose) {
  const double cell_m = 0.05 * (1 << level);
  double sum = 0.0;
  for (const Eigen::Vector2f& point : points) {
    const Eigen::Vector2d end = pose * Eigen::Vector2d(point.cast<double>());
    const Cell hit{static_cast<int>(std::floor(end.x() / cell_m)),
                   static_cast<int>(std::floor(end.y() / cell_m))};
    const double probability = grid.levelProbability(level, hit);
    if (probability > 0.5) sum += probability;
  }
  return sum / static_cast<double>(points.size());
}

TEST(VotingLikelihood, SumsTheProbabilitiesOfOccupiedCells) {
  const OccupancyGrid grid = wall();
  // Two points on the wall, one in front of it in free space, one behind it in unknown space.
  const Points points = {{0.01F, 2.01F}, {0.12F, 2.04F}, {0.0F, 1.5F}, {0.0F, 2.17F}};
  EXPECT_NEAR(votingLikelihood(grid, 0, points, Pose2()), 2 * 0.9 / 4, 1e-4);
  EXPECT_NEAR(votingLikelihood(grid, 1, points, Pose2()), 2 * 0.9 / 4, 1e-4);
  EXPECT_NEAR(votingLikelihood(grid, 2, points, Pose2()), 3 * 0.9 / 4, 1e-4)
      << "the 20 cm cell is from 2.0 to 2.2 m";
  EXPECT_NEAR(votingLikelihood(grid, 0, points, Pose2(0.0, -0.14, 0.0)), 0.9 / 4, 1e-4);
  EXPECT_EQ(votingLikelihood(grid, 0, {}, Pose2()), 0.0);
}

TEST(VotingLikelihood, EqualsTheDirectComputation) {
  const Submap map = room::map();
  const Points points = hitsOf(room::scanFrom(Pose2(0.2, 0.1, 0.3)));
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Pose2 pose(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-kPi, kPi));
    for (int level = 0; level < OccupancyGrid::kLevels; ++level) {
      // A point on the border of a cell may be rounded to either side.
      ASSERT_NEAR(votingLikelihood(map.grid(), level, points, pose),
                  countedVotes(map.grid(), level, points, pose), 1.5 / 360);
    }
  }
}

TEST(StandardCandidates, AreNormalAndSortedByLikelihood) {
  const StandardCandidates candidates = standardCandidates(20000, 1);
  ASSERT_EQ(candidates.size(), 20000U);
  EXPECT_EQ(candidates.front(), Eigen::Vector3f::Zero());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i > 0) {
      ASSERT_GE(candidates[i].squaredNorm(), candidates[i - 1].squaredNorm());
    }
    mean += candidates[i].cast<double>() / 20000;
    squares += candidates[i].cast<double>().cwiseAbs2() / 20000;
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(mean(axis), 0.0, 0.03);
    EXPECT_NEAR(squares(axis), 1.0, 0.04);
  }
}

TEST(StandardCandidates, AreDeterminedByTheSeed) {
  EXPECT_EQ(standardCandidates(50, 7), standardCandidates(50, 7));
  EXPECT_NE(standardCandidates(50, 7), standardCandidates(50, 8));
  EXPECT_EQ(standardCandidates(1, 7).size(), 1U);
}

TEST(MotionSpread, GrowsWithTheMotion) {
  ProgressiveConfig config;
  config.motion_share = 0.5;
  config.turn_share = 0.25;
  config.min_sigma_m = 0.02;
  config.min_sigma_rad = 0.01;
  const CandidateSpread still = motionSpread(Pose2(1, 2, 3), Pose2(1, 2, 3), config);
  EXPECT_EQ(still.linear_m, 0.02);
  EXPECT_EQ(still.angular_rad, 0.01);
  const CandidateSpread moving = motionSpread(Pose2(1, 2, 3.1), Pose2(1.3, 2.4, -3.1), config);
  EXPECT_NEAR(moving.linear_m, 0.5 * 0.5, 1e-12);
  EXPECT_NEAR(moving.angular_rad, 0.25 * (2 * kPi - 6.2), 1e-12) << "the smaller angle";
}

TEST(BestCandidate, IsTheCandidateWithTheMaximumPosterior) {
  const Submap map = room::map();
  const Pose2 truth(0.2, 0.1, 0.3), center = truth * Pose2(0.05, -0.06, 0.03);
  const Points points = hitsOf(room::scanFrom(truth));
  const StandardCandidates candidates = standardCandidates(500, 3);
  const CandidateSpread spread{0.1, 0.05};
  for (int level = 0; level < OccupancyGrid::kLevels; ++level) {
    double best = -1e9, total = 0.0;
    Pose2 winner;
    Eigen::Vector3d first = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3f& candidate : candidates) {
      const Eigen::Vector3d offset =
          candidate.cast<double>().cwiseProduct(Eigen::Vector3d(0.1, 0.1, 0.05));
      const Pose2 pose(center.x + offset.x(), center.y + offset.y(), center.yaw + offset.z());
      const double vote = votingLikelihood(map.grid(), level, points, pose);
      const double prior = 0.5 * static_cast<double>(candidate.squaredNorm());
      total += std::exp(kBeams * vote);
      first += std::exp(kBeams * vote) * offset;
      if (kBeams * vote - prior <= best) continue;
      best = kBeams * vote - prior;
      winner = pose;
    }
    const LevelEstimate estimate =
        bestCandidate(map.grid(), level, points, center, spread, candidates, kBeams);
    EXPECT_EQ(estimate.pose, winner);
    EXPECT_EQ(estimate.vote, votingLikelihood(map.grid(), level, points, winner));
    // Candidates that are dropped early have a weight below e^-6.
    EXPECT_NEAR(estimate.mean.x, center.x + first.x() / total, 0.005);
    EXPECT_NEAR(estimate.mean.y, center.y + first.y() / total, 0.005);
    EXPECT_NEAR(estimate.mean.yaw, center.yaw + first.z() / total, 0.0025);
  }
}

TEST(BestCandidate, IsTheCenterIfNoPointVotes) {
  const OccupancyGrid empty{OccupancyGridConfig()};
  const Pose2 center(1, 2, 3);
  for (const Points& points : {Points(), lineAt(2.0F)}) {
    const LevelEstimate estimate =
        bestCandidate(empty, 1, points, center, {0.1, 0.05}, standardCandidates(100, 1), kBeams);
    EXPECT_EQ(estimate.pose, center);
    EXPECT_EQ(estimate.mean, center);
    EXPECT_EQ(estimate.vote, 0.0);
    // The posterior is that of the motion model.
    EXPECT_NEAR(estimate.covariance(0, 0), 0.01, 0.004);
    EXPECT_NEAR(estimate.covariance(2, 2), 0.0025, 0.001);
  }
}

TEST(ProgressiveRefiner, FindsADisplacementWithinTheFinestCell) {
  // The room is rotated, so that the walls cross the cells at many positions. If walls were
  // parallel to the cells, all points could have the same error of up to half a cell, which votes
  // cannot resolve.
  const Pose2 map_T_room(0.013, 0.021, 0.3);
  const Submap map = room::map(map_T_room);
  const ProgressiveRefiner refiner{ProgressiveConfig()};
  const Pose2 in_room(0.2, 0.1, 0.3), truth = map_T_room * in_room;
  const Points points = hitsOf(room::scanFrom(in_room));
  for (const Pose2& offset : {Pose2(0.12, 0.0, 0.0), Pose2(-0.08, 0.1, 0.04), Pose2(0, 0, -0.08)}) {
    const Refinement result = refiner.refine(map.grid(), points, truth * offset, {0.1, 0.05});
    const Pose2 error = truth.inverse() * result.poses.back();
    EXPECT_LT(error.distance(), 0.01);
    EXPECT_LT(std::abs(error.yaw), 0.003);
    EXPECT_EQ(result.levels, 3);
    EXPECT_FALSE(result.stopped);
  }
}

TEST(ProgressiveRefiner, CandidateSpaceShrinks) {
  ProgressiveConfig config;
  config.shrink = 0.5;
  const Submap map = room::map();
  const Points points = hitsOf(room::scanFrom(Pose2()));
  const Refinement result =
      ProgressiveRefiner(config).refine(map.grid(), points, Pose2(0.05, 0, 0), {0.2, 0.08});
  ASSERT_EQ(result.levels, 3);
  for (std::size_t i = 0; i < kMatchStages; ++i) {
    EXPECT_NEAR(result.spreads[i].linear_m, 0.2 / (1 << i), 1e-12);
    EXPECT_NEAR(result.spreads[i].angular_rad, 0.08 / (1 << i), 1e-12);
  }
}

// The line is in the same 20 cm cell as the wall, but 7 cm away from its 10 cm cell. So the first
// level makes no correction and the second one at least 7 cm.
TEST(ProgressiveRefiner, StopsIfAFinerCorrectionExceedsTheCoarserOne) {
  const OccupancyGrid grid = wall();
  const Points points = lineAt(2.17F);
  for (const double slack_cells : {0.0, 0.3}) {  // exactly as in the paper, and 6 cm
    ProgressiveConfig config;
    config.slack_cells = slack_cells;
    const Refinement result =
        ProgressiveRefiner(config).refine(grid, points, Pose2(), {0.1, 0.001});
    EXPECT_TRUE(result.stopped);
    EXPECT_EQ(result.levels, 1);
    EXPECT_EQ(result.corrections_m[0], 0.0);
    EXPECT_GE(result.corrections_m[1], 0.07);
    for (const Pose2& pose : result.poses)
      EXPECT_EQ(pose, Pose2()) << "the coarse pose must be kept";
    EXPECT_NEAR(result.finest.vote, 0.9, 1e-4);
  }
}

TEST(ProgressiveRefiner, ContinuesIfTheCoarserLevelCannotResolveTheCorrection) {
  ProgressiveConfig config;
  config.slack_cells = 0.75;  // 15 cm
  config.shrink = 1.0;        // the 5 cm cell of the wall is another 5 cm away
  const Refinement result =
      ProgressiveRefiner(config).refine(wall(), lineAt(2.17F), Pose2(), {0.1, 0.001});
  EXPECT_FALSE(result.stopped);
  EXPECT_EQ(result.levels, 3);
  EXPECT_GT(result.corrections_m[1], result.corrections_m[0]);
  EXPECT_GE(result.poses[1].y, -0.17 - 1e-6);
  EXPECT_LE(result.poses[1].y, -0.07 + 1e-6);
  EXPECT_GE(result.poses[2].y, -0.17 - 1e-6);
  EXPECT_LE(result.poses[2].y, -0.12 + 1e-6) << "in the 5 cm cell of the wall";
}

}  // namespace
}  // namespace kestrel
