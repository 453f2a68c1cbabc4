// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/odometry_slip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

/// A hall with oblique walls and three pillars.
const std::vector<room::Segment> kHall = {{-7, -5, 1, -9},  {1, -9, 9, -2},  {9, -2, 6, 7},
                                          {6, 7, -5, 8},    {-5, 8, -7, -5}, {-4, -4, -3, -3.5},
                                          {3, -5, 3.5, -4}, {-3, 4, -2, 5}};
const Pose2 kLast(0.5, 0.3, 0.2), kDrivenBack(-1.0, 0.0, 0.05), kForward(1.0, 0.0, 0.05);

/// A match near the odometry that does not fit.
const MatchResult kRefused = [] {
  MatchResult result;
  result.pose = kLast * kForward;
  return result;
}();

/// The match of a scan from kLast * `moved`, where the odometry says kForward.
std::optional<MatchResult> matchedAt(const Pose2& moved, const std::vector<room::Segment>& walls,
                                     const MatchResult& refused = kRefused,
                                     const SlipKind& kind = SlipKind()) {
  Submap map{OccupancyGridConfig()};
  for (const double x : {-1.0, 0.0, 1.0})
    map.insert(room::scanFrom(Pose2(x, 0.2, 0.1), walls), Pose2(x, 0.2, 0.1));
  const Points points = hitsOf(room::scanFrom(kLast * moved, walls));
  MatchRequest request{points, kLast * kForward, {kLast * kForward}};
  request.prior = MotionPrior{kLast * kForward, 0.05, 0.02};
  return matchAfterSlip(map, request, kLast, refused, MatcherConfig(), kind).match;
}

TEST(OdometrySlip, AMotionAgainstTheOdometryIsFound) {
  const auto found = matchedAt(kDrivenBack, kHall);
  ASSERT_TRUE(found);
  EXPECT_LT((kLast * kDrivenBack).between(found->pose).distance(), 0.03);
  EXPECT_TRUE(matchedAt(Pose2(), kHall)) << "the wheels turn, and the vehicle stands";
}

TEST(OdometrySlip, FartherThanTheOdometryNothingIsFound) {
  EXPECT_FALSE(matchedAt(Pose2(-1.8, 0.0, 0.05), kHall));
}

TEST(OdometrySlip, WhatFitsInSeveralWaysIsNoMatch) {
  EXPECT_FALSE(matchedAt(kDrivenBack, room::corridor()));
  MatchResult refused;
  refused.score = refused.known = 0.98;
  EXPECT_FALSE(matchedAt(kDrivenBack, kHall, refused)) << "it fits as well near the odometry";
}

TEST(OdometrySlip, WithoutASlipOnlyTheWayBackIsFound) {
  const SlipKind kind{false, true};
  EXPECT_TRUE(matchedAt(kDrivenBack, kHall, kRefused, kind));
  EXPECT_FALSE(matchedAt(Pose2(), kHall, kRefused, kind));
}

TEST(OdometrySlip, AMuchBetterPoseNearTheRefusedOneIsFound) {
  MatchResult refused;
  refused.pose = kLast * kDrivenBack * Pose2(0.4, 0.0, 0.0);
  refused.score = refused.known = 0.7;
  EXPECT_TRUE(matchedAt(kDrivenBack, kHall, refused));
}

TEST(OdometrySlip, APoseOnTheWayBackThatWasRefusedIsNoOtherPose) {
  MatchResult refused;
  refused.pose = kLast * kDrivenBack;
  refused.score = refused.known = 0.98;
  EXPECT_TRUE(matchedAt(kDrivenBack, kHall, refused, {true, true}));
}

/// It learns this on the way back, and then predicts that the vehicle goes on like that.
TEST(OdometrySlip, AMapperLearnsThatTheOdometryDoesNotKnowTheDirection) {
  constexpr int kForwardSteps = 8, kSteps = 14;
  Mapper mapper{MapperConfig()};
  double x = -4.0, measured = 0.0;
  int reversed_steps = 0;
  for (int i = 0; i < kSteps; ++i) {
    PlanarScan scan = room::scanFrom(Pose2(x, 0.2, 0.0), kHall);
    scan.stamp = scan.time = 2.0 * i;
    const MapperResult result = mapper.process(scan, Pose2(measured, 0.0, 0.0));
    EXPECT_NEAR(result.pose.x, x + 4.0, 0.05) << i;
    reversed_steps += result.reversed ? 1 : 0;
    EXPECT_FALSE(result.reversed && i <= kForwardSteps) << i;
    const double step = i < kForwardSteps ? 1.0 : -1.0;
    x += step;
    measured += std::abs(step);
  }
  EXPECT_EQ(reversed_steps, kSteps - 1 - kForwardSteps);
}

TEST(OdometrySlip, AMapperFollowsAVehicleWhoseOdometryDoesNotKnowTheDirection) {
  constexpr int kForwardSteps = 8, kSteps = 12;
  Mapper mapper{MapperConfig()};
  double x = -4.0, measured = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    PlanarScan scan = room::scanFrom(Pose2(x, 0.2, 0.0), kHall);
    scan.stamp = scan.time = 2.0 * i;
    const MapperResult result = mapper.process(scan, Pose2(measured, 0.0, 0.0));
    EXPECT_NEAR(result.pose.x, x + 4.0, 0.05) << i;
    const double step = i < kForwardSteps ? 1.0 : -1.8;
    x += step;
    measured += std::abs(step);
  }
}

}  // namespace
}  // namespace kestrel
