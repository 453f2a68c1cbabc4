// SPDX-License-Identifier: BSD-3-Clause
// Tests of the ICP matcher and its submap options. matcher_test.cpp tests all matchers.

#include <gtest/gtest.h>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/matching/matcher.h"
#include "kestrel_slam/sensor/planar_scan.h"
#include "room.h"

namespace kestrel {
namespace {

struct Variant {
  const char* metric;
  const char* reference;
  bool stitching;
};

MatcherConfig configOf(const Variant& variant) {
  MatcherConfig config;
  config.method = "icp";
  config.icp.metric = variant.metric;
  config.icp.reference = variant.reference;
  config.icp.stitching = variant.stitching;
  return config;
}

/// The room seen by three scans, with the submap options of the matcher.
Submap roomFor(const MatcherConfig& config) {
  Submap map(OccupancyGridConfig(), submapOptions(config));
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)}) {
    map.insert(room::scanFrom(pose), pose);
  }
  return map;
}

class IcpVariants : public ::testing::TestWithParam<Variant> {};

TEST_P(IcpVariants, FindsAKnownPose) {
  const MatcherConfig config = configOf(GetParam());
  const Submap map = roomFor(config);
  const std::unique_ptr<Matcher> matcher = makeMatcher(config);
  for (const Pose2& truth : {Pose2(0.2, 0.1, 0.3), Pose2(-0.8, 0.6, -2.0), Pose2(0.9, -0.7, 3.1)}) {
    const Points points = hitsOf(room::scanFrom(truth));
    const Pose2 initial_guess = truth * Pose2(0.1, -0.08, 0.08);
    const MatchResult result = matcher->match(map, {points, initial_guess, {initial_guess}});
    EXPECT_LT((truth.inverse() * result.pose).distance(), 0.03);
    EXPECT_NEAR(normalizeAngle(result.pose.yaw - truth.yaw), 0.0, 0.01);
    EXPECT_TRUE(result.converged);
    EXPECT_GT(result.iterations, 3);
    EXPECT_GT(result.score, 0.8);
    EXPECT_EQ(result.stages.back().pose, result.pose);
    EXPECT_EQ(result.stages.back().score, result.score);
    for (const StageEstimate& stage : result.stages) EXPECT_GT(stage.score, 0.5);
  }
}

TEST_P(IcpVariants, FollowsADriveWithoutOdometry) {
  MapperConfig config;
  config.matcher = configOf(GetParam());
  Mapper mapper(config);
  const auto drive = [](int i) {
    const double s = 0.1 * i;
    return Pose2(1.2 * std::sin(s), 0.8 * std::sin(2 * s), 0.5 * s);
  };
  mapper.reset(drive(0));
  for (int i = 0; i < 60; ++i) {
    PlanarScan scan = room::scanFrom(drive(i));
    scan.stamp = scan.time = 0.1 * i;
    const MapperResult result = mapper.process(scan);
    ASSERT_EQ(result.state, MatchState::kOk) << i;
    ASSERT_LT((drive(i).inverse() * result.pose).distance(), 0.05) << i;
    ASSERT_LT(std::abs(normalizeAngle(drive(i).yaw - result.pose.yaw)), 0.015) << i;
  }
}

TEST_P(IcpVariants, StaysFiniteWithFewPoints) {
  const MatcherConfig config = configOf(GetParam());
  const Submap map = roomFor(config), empty(OccupancyGridConfig(), submapOptions(config));
  const std::unique_ptr<Matcher> matcher = makeMatcher(config);
  Points line;
  for (int i = 0; i < 50; ++i) line.push_back({3.9F, -2.0F + 0.05F * static_cast<float>(i)});
  const Points one = {{4.0F, 0.0F}}, two = {{4.0F, 0.0F}, {-4.0F, 1.0F}}, none;
  for (const Points& points : {none, one, two, line}) {
    for (const Submap* place : {&map, &empty}) {
      const MatchResult result = matcher->match(*place, {points, Pose2(), {Pose2()}, true});
      ASSERT_TRUE(result.pose.isFinite());
      ASSERT_TRUE(result.covariance.allFinite());
      ASSERT_TRUE(std::isfinite(result.score));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, IcpVariants,
                         ::testing::Values(Variant{"point_to_point", "map", false},
                                           Variant{"point_to_line", "map", false},
                                           Variant{"point_to_point", "last_scans", false},
                                           Variant{"point_to_line", "last_scans", false},
                                           Variant{"point_to_point", "map", true},
                                           Variant{"point_to_line", "map", true},
                                           Variant{"point_to_point", "last_scans", true},
                                           Variant{"point_to_line", "last_scans", true}));

TEST(IcpMatcher, FindsARotationThatNoInitialGuessPredicts) {
  const MatcherConfig config = configOf({"point_to_line", "map", false});
  const Submap map = roomFor(config);
  const Pose2 truth(0.2, 0.1, 1.2), initial_guess(0.2, 0.1, 0.0);
  const Points points = hitsOf(room::scanFrom(truth));
  MatchRequest request{points, initial_guess, {initial_guess}};
  EXPECT_NEAR(makeMatcher(config)->match(map, request).pose.yaw, 1.2, 0.01);
  request.yaw_known = true;
  EXPECT_LT(std::abs(makeMatcher(config)->match(map, request).pose.yaw), 1.0);
}

TEST(IcpMatcher, TakesTheBestOfTheInitialGuesses) {
  const MatcherConfig config = configOf({"point_to_point", "map", false});
  const Submap map = roomFor(config);
  const Pose2 truth(0.2, 0.1, 0.3);
  const Points points = hitsOf(room::scanFrom(truth));
  const Pose2 wrong = truth * Pose2(1.5, 1.0, 0.5), near = truth * Pose2(0.05, 0.0, 0.02);
  MatchRequest request{points, near, {wrong, near}};
  request.yaw_known = true;
  const MatchResult result = makeMatcher(config)->match(map, request);
  EXPECT_LT((truth.inverse() * result.pose).distance(), 0.02);
}

TEST(IcpMatcher, ResultsDoNotDependOnTheCache) {
  for (const char* reference : {"map", "last_scans"}) {
    const MatcherConfig config = configOf({"point_to_line", reference, false});
    Submap map = roomFor(config);
    const std::unique_ptr<Matcher> old = makeMatcher(config);
    for (int i = 0; i < 12; ++i) {
      const Pose2 truth(0.3 * i, 0.1, 0.2 * i), initial_guess = truth * Pose2(0.05, 0.05, 0.03);
      const Points points = hitsOf(room::scanFrom(truth));
      const MatchRequest request{points, initial_guess, {initial_guess}};
      const MatchResult cached = old->match(map, request);
      const MatchResult fresh = makeMatcher(config)->match(map, request);
      ASSERT_NEAR((fresh.pose.inverse() * cached.pose).distance(), 0.0, 1e-9) << i;
      ASSERT_EQ(fresh.iterations, cached.iterations) << i;
      if (i % 3 == 2) map.insert(room::scanFrom(truth), truth);
      if (i == 8) map.clear();
    }
    EXPECT_EQ(old->match(map, {Points(), Pose2(), {Pose2()}}).score, 0.0);
  }
}

TEST(IcpMatcher, UsesOnlyTheLastScansAsReference) {
  MatcherConfig config = configOf({"point_to_line", "last_scans", false});
  const Pose2 shift(0.2, 0.0, 0.0);
  for (const int count : {1, 2}) {
    config.icp.last_scans = count;
    Submap map(OccupancyGridConfig(), submapOptions(config));
    map.insert(room::scanFrom(Pose2()), Pose2());
    map.insert(room::scanFrom(Pose2()), shift);  // the same scan, 0.2 m away in the map
    const Points points = hitsOf(room::scanFrom(Pose2()));
    const MatchResult result = makeMatcher(config)->match(map, {points, Pose2(), {Pose2()}});
    // With one scan the reference is only the second one. With two, the first one fits exactly.
    EXPECT_NEAR(result.pose.x, count == 1 ? 0.2 : 0.0, 1e-3);
    EXPECT_NEAR(result.pose.y, 0.0, 1e-3);
  }
}

}  // namespace
}  // namespace kestrel
