// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/mapper.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <limits>
#include <random>

#include "kestrel_slam/matching/thinned.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// A drive through the room with turns, 60 scans.
Pose2 drive(int i) {
  const double s = 0.1 * i;
  return {1.2 * std::sin(s), 0.8 * std::sin(2 * s), 0.5 * s};
}

PlanarScan scanAt(int i) {
  PlanarScan scan = room::scanFrom(drive(i));
  scan.stamp = scan.time = 0.1 * i;
  return scan;
}

/// A circle with 1 m radius in free space: a scan that does not fit anywhere.
PlanarScan scanElsewhere() {
  PlanarScan circle;
  for (int i = 0; i < 90; ++i) {
    const auto angle = static_cast<float>(i) * 0.07F;
    circle.rays.push_back({Eigen::Vector2f::Zero(), {std::cos(angle), std::sin(angle)}, true});
  }
  return circle;
}

void expectFinite(const MapperResult& result) {
  ASSERT_TRUE(result.pose.isFinite());
  ASSERT_TRUE(result.covariance.allFinite());
  ASSERT_TRUE(std::isfinite(result.match.score));
  ASSERT_FALSE(std::isnan(result.evaluation));
}

TEST(Mapper, FollowsADriveWithoutOdometry) {
  Mapper mapper{MapperConfig()};
  mapper.reset(drive(0));
  for (int i = 0; i < 60; ++i) {
    const MapperResult result = mapper.process(scanAt(i));
    ASSERT_EQ(result.state, MatchState::kOk) << i;
    ASSERT_LT((drive(i).inverse() * result.pose).distance(), 0.03) << i;
    ASSERT_LT(std::abs(normalizeAngle(drive(i).yaw - result.pose.yaw)), 0.01) << i;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(result.covariance);
    ASSERT_GE(solver.eigenvalues()(0), 0.0);
  }
}

TEST(Mapper, WithTheGraphScansAreMatchedInFineCells) {
  MapperConfig config;
  config.grid.resolution_m = 0.1;
  EXPECT_DOUBLE_EQ(config.matchedGrid().resolution_m, 0.1) << "this map is the one that is shown";
  config.window.enabled = true;
  EXPECT_DOUBLE_EQ(config.matchedGrid().resolution_m, 0.05);
  const Mapper mapper(config);
  EXPECT_FLOAT_EQ(mapper.map().surface().resolution(), 0.05F);
  config.grid.resolution_m = 0.025;
  EXPECT_DOUBLE_EQ(config.matchedGrid().resolution_m, 0.025);
}

TEST(Mapper, FollowsADriveWithTheProgressiveMatcher) {
  MapperConfig config;
  config.matcher.method = "progressive";
  Mapper mapper{config};
  // The room is rotated, so that the walls cross the cells at many positions. Votes cannot resolve
  // the position of a wall within its cells. If the walls were parallel to the axes, all points of
  // a wall would have the same error: up to 0.09 m here.
  const Pose2 map_T_room(0.013, 0.021, 0.3);
  mapper.reset(map_T_room * drive(0));
  for (int i = 0; i < 60; ++i) {
    const MapperResult result = mapper.process(scanAt(i));
    const Pose2 error = (map_T_room * drive(i)).inverse() * result.pose;
    ASSERT_EQ(result.state, MatchState::kOk) << i;
    ASSERT_LT(error.distance(), 0.02) << i;
    ASSERT_LT(std::abs(error.yaw), 0.005) << i;
    expectFinite(result);
  }
}

TEST(Mapper, InsertsOnlyAfterMotion) {
  Mapper mapper{MapperConfig()};
  EXPECT_TRUE(mapper.process(room::scanFrom(Pose2())).inserted);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(mapper.process(room::scanFrom(Pose2())).inserted);
  EXPECT_FALSE(mapper.process(room::scanFrom(Pose2(0.1, 0, 0))).inserted);
  EXPECT_TRUE(mapper.process(room::scanFrom(Pose2(0.27, 0, 0))).inserted);
  EXPECT_FALSE(mapper.process(room::scanFrom(Pose2(0.27, 0, 0.15))).inserted);
  EXPECT_TRUE(mapper.process(room::scanFrom(Pose2(0.27, 0, 0.28))).inserted);
}

TEST(Mapper, AScanThatDoesNotFitIsLostAndNotInserted) {
  Mapper mapper{MapperConfig()};
  mapper.process(room::scanFrom(Pose2()));
  const MapSnapshot before = mapper.snapshot();
  for (int i = 0; i < 5; ++i) {
    PlanarScan scan = scanElsewhere();
    scan.stamp = scan.time = i + 1.0;  // s: the velocity cannot carry the pose so long
    const MapperResult result = mapper.process(scan);
    EXPECT_EQ(result.state, MatchState::kLost);
    EXPECT_TRUE(result.searched);
    EXPECT_FALSE(result.inserted);
    EXPECT_EQ(result.pose, mapper.pose());
    EXPECT_GE(result.covariance(0, 0), 1.0);
    EXPECT_GE(result.covariance(2, 2), 0.25);
  }
  EXPECT_EQ(mapper.snapshot().cells, before.cells);
  PlanarScan scan = room::scanFrom(Pose2());
  scan.stamp = scan.time = 6.0;
  EXPECT_NE(mapper.process(scan).state, MatchState::kLost) << "must recover";
}

TEST(Mapper, TheOdometryCarriesThePoseWhereNoScanFits) {
  Mapper mapper{MapperConfig()};
  mapper.process(room::scanFrom(Pose2()), Pose2(10, 10, 1));
  for (int i = 1; i <= 10; ++i) {
    const MapperResult result =
        mapper.process(scanElsewhere(), Pose2(10, 10, 1) * Pose2(0.05 * i, 0, 0));
    EXPECT_EQ(result.state, MatchState::kDegraded);
    EXPECT_TRUE(result.carried);
  }
  EXPECT_NEAR(mapper.pose().x, 0.5, 0.001);
  const MapperResult back =
      mapper.process(room::scanFrom(Pose2(0.55, 0, 0)), Pose2(10, 10, 1) * Pose2(0.55, 0, 0));
  EXPECT_NE(back.state, MatchState::kLost);
  EXPECT_NEAR(back.pose.x, 0.55, 0.02);
}

TEST(Mapper, ResetClearsTheMapAndSetPoseKeepsIt) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 20; ++i) mapper.process(scanAt(i));
  mapper.reset(Pose2(5, 6, 1));
  EXPECT_TRUE(mapper.snapshot().empty());
  EXPECT_EQ(mapper.process(room::scanFrom(Pose2())).pose, Pose2(5, 6, 1));

  mapper.reset();
  mapper.process(room::scanFrom(Pose2()));
  mapper.setPose(Pose2(0.9, 0.5, 0.2));  // the vehicle was carried; the pose is approximate
  const MapperResult result = mapper.process(room::scanFrom(Pose2(1.0, 0.4, 0.3)));
  EXPECT_EQ(result.state, MatchState::kOk);
  EXPECT_NEAR(result.pose.x, 1.0, 0.02);
  EXPECT_NEAR(result.pose.y, 0.4, 0.02);
  EXPECT_NEAR(result.pose.yaw, 0.3, 0.01);
}

TEST(Mapper, TheEvaluationFunctionPreventsInsertion) {
  MapperConfig config;
  config.evaluation.threshold = 1.0;  // f is at least 1, so no scan is inserted
  for (const bool enabled : {true, false}) {
    config.evaluation.enabled = enabled;
    Mapper mapper(config);
    mapper.process(room::scanFrom(Pose2()));
    EXPECT_EQ(mapper.process(room::scanFrom(Pose2(0.3, 0, 0))).inserted, !enabled);
  }
}

TEST(Mapper, IsDeterministic) {
  Mapper first{MapperConfig()}, second{MapperConfig()};
  for (int i = 0; i < 40; ++i) {
    ASSERT_EQ(first.process(scanAt(i)).pose, second.process(scanAt(i)).pose);
  }
  EXPECT_EQ(first.snapshot().cells, second.snapshot().cells);
}

TEST(Mapper, FourBeamsAreNotMatchedButTheOdometryCarriesThePose) {
  Mapper mapper{MapperConfig()};
  MapperResult result;
  for (int i = 0; i <= 40; ++i) {
    const Pose2 truth(-1.0 + 0.05 * i, 0.3, 0.02 * i);
    PlanarScan scan = room::scanFrom(truth, room::walls(), 4);
    scan.stamp = scan.time = 0.1 * i;
    if (i == 0) mapper.reset(truth);
    result = mapper.process(scan, Pose2(5, 5, 1) * truth);
    EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 1e-6) << i;
  }
  EXPECT_TRUE(result.carried);
  EXPECT_EQ(result.state, MatchState::kDegraded);
  EXPECT_GT(std::sqrt(result.covariance(0, 0)), 0.5) << "30 % of 2 m";
  EXPECT_LT(std::sqrt(result.covariance(0, 0)), 1.5);
}

TEST(Mapper, ADenseScanIsMatchedWithAPartOfItsPoints) {
  Mapper mapper{MapperConfig()};
  mapper.process(room::scanFrom(Pose2(), room::walls(), 20000));
  const Pose2 truth(0.1, -0.05, 0.08);
  const MapperResult result = mapper.process(room::scanFrom(truth, room::walls(), 20000));
  EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.01);
  EXPECT_EQ(thinned(hitsOf(room::scanFrom(truth, room::walls(), 20000)), 1100).size(), 1112U);
}

TEST(Mapper, ReportsAFullMapAndContinues) {
  MapperConfig config;
  config.grid.memory_limit_mb = 0.05;
  Mapper mapper(config);
  bool full = false;
  for (int i = 0; i < 60; ++i) {
    const MapperResult result = mapper.process(scanAt(i));
    expectFinite(result);
    full |= result.map_full;
  }
  EXPECT_TRUE(full);
  EXPECT_LT(mapper.memoryBytes(), 2000000U);
}

TEST(Mapper, IgnoresInvalidNumbers) {
  Mapper mapper{MapperConfig()};
  PlanarScan scan = room::scanFrom(Pose2());
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  scan.rays.push_back({Eigen::Vector2f::Zero(), {nan, 1.0F}, true});
  scan.rays.push_back({Eigen::Vector2f::Zero(), {1e30F, 1.0F}, true});
  scan.rays.push_back({{std::numeric_limits<float>::infinity(), 0.0F}, {1.0F, 1.0F}, false});
  expectFinite(mapper.process(scan, Pose2(1, 2, 3)));
  EXPECT_LT(mapper.snapshot().width, 200);
  Pose2 broken;
  broken.x = kNoNumber;
  mapper.setPose(broken);
  EXPECT_EQ(mapper.pose(), Pose2());
  mapper.reset(broken);
  EXPECT_FALSE(mapper.snapshot().empty());
  mapper.setPose(Pose2(1e9, 0, 0));
  EXPECT_EQ(mapper.pose(), Pose2());
  expectFinite(mapper.process(scan, broken));
  EXPECT_EQ(mapper.process(scan, Pose2(1, 2, 3)).state, MatchState::kOk);
  expectFinite(mapper.process(PlanarScan()));
}

TEST(Mapper, StaysFiniteForThousandsOfGarbageScans) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<float> place(-8.0F, 8.0F);
  std::uniform_real_distribution<double> odometry(-1e3, 1e3);
  MapperConfig config;
  config.matcher.near_window = {0.1, 0.1};  // small windows, so that the test is fast
  config.matcher.wide_window = {0.2, 0.2};
  Mapper mapper(config);
  for (int i = 0; i < 3000; ++i) {
    PlanarScan scan;
    scan.time = scan.stamp = i % 7 == 0 ? odometry(random) : 0.1 * i;
    const std::size_t beams = random() % 20;
    for (std::size_t k = 0; k < beams; ++k) {
      PlanarRay ray{
          {place(random), place(random)}, {place(random), place(random)}, random() % 2 == 0};
      if (random() % 50 == 0) ray.end.x() = std::numeric_limits<float>::quiet_NaN();
      if (random() % 50 == 0) ray.end.y() *= 1e20F;
      scan.rays.push_back(ray);
    }
    std::optional<Pose2> odom;
    if (random() % 3 == 0) odom = Pose2(odometry(random), odometry(random), odometry(random));
    if (random() % 100 == 0) mapper.setPose(Pose2(odometry(random), 0, odometry(random)));
    if (random() % 200 == 0) mapper.reset(Pose2(0, odometry(random), 1));
    expectFinite(mapper.process(scan, odom));
  }
}

}  // namespace
}  // namespace kestrel
