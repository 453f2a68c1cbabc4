// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/submap_graph.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "kestrel_slam/graph/marginals.h"
#include "loop_world.h"

namespace kestrel {
namespace {

using loop_world::acceptedLoops;
using loop_world::Drive;

constexpr double kYawDrift = 0.0003;  // rad for each keyframe: 2 m after one lap

TEST(SubmapGraph, ALoopIsClosed) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kYawDrift);
  double before = 0.0;
  for (const Pose2& pose : loop_world::laps(0.9)) drive.add(pose, graph);
  before = drive.lastError(graph);
  EXPECT_GT(before, 0.5);
  EXPECT_EQ(acceptedLoops(graph), 0U) << "no place was visited twice";
  SubmapGraph closed{MapperConfig(), LoopConfig()};
  Drive whole(loop_world::ring(), kYawDrift);
  for (const Pose2& pose : loop_world::laps(1.4)) whole.add(pose, closed);
  closed.finish();
  EXPECT_GE(acceptedLoops(closed), 3U);
  EXPECT_LT(whole.worstLoop(closed), 0.15);
  EXPECT_LT(whole.lastError(closed), 0.1);
}

TEST(SubmapGraph, TheSameInputGivesTheSamePoses) {
  std::vector<Pose2> poses[2];
  for (std::vector<Pose2>& result : poses) {
    SubmapGraph graph{MapperConfig(), LoopConfig()};
    Drive drive(loop_world::ring(), kYawDrift);
    for (const Pose2& pose : loop_world::laps(1.2)) drive.add(pose, graph);
    graph.finish();
    for (std::size_t i = 0; i < graph.keyframes().size(); ++i) result.push_back(graph.poseOf(i));
  }
  EXPECT_EQ(poses[0], poses[1]);
}

TEST(SubmapGraph, AKeyframeKnowsTheHeightOfItsScan) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kYawDrift);
  drive.add(loop_world::laps(0.1)[0], graph);
  drive.height = {1.5F, {0.1F, -0.2F}};
  drive.add(loop_world::laps(0.1)[1], graph);
  EXPECT_FALSE(graph.keyframes()[0].keyframe->height.isKnown());
  const Keyframe& keyframe = *graph.keyframes()[1].keyframe;
  EXPECT_EQ(keyframe.height.base_m, 1.5F);
  EXPECT_EQ(keyframe.planarScan().height.slope, Eigen::Vector2f(0.1F, -0.2F));
}

/// A corridor with rooms that all look the same: without drift that tells them apart, a match is
/// ambiguous, and with a wrong one all rooms would be drawn over each other.
TEST(SubmapGraph, IdenticalRoomsAreNotMerged) {
  std::vector<room::Segment> walls = {{-3, -1, 60, -1}};
  for (double x = 0.0; x < 60.0; x += 3.0) {
    walls.insert(walls.end(), {{x, 1, x + 2, 1}, {x, 1, x, 4}, {x, 4, x + 3, 4}});
    loop_world::addBox(walls, x + 1.9, 2.5, 0.5, 0.6);
  }
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Drive drive(walls, 0.0001);
  for (double x = 1.0; x < 55.0; x += 0.25) drive.add(Pose2(x, 0.0, 0.0), graph);
  graph.finish();
  EXPECT_LT(drive.worstLoop(graph), 0.3);
  EXPECT_EQ(acceptedLoops(graph), 0U) << "no place was visited twice";
}

/// A pose is less uncertain after a loop than before, and its error fits to what is claimed.
TEST(SubmapGraph, ALoopMakesThePoseCertain) {
  SubmapGraph open{MapperConfig(), LoopConfig()}, closed{MapperConfig(), LoopConfig()};
  Drive lap(loop_world::ring(), kYawDrift), laps(loop_world::ring(), kYawDrift);
  for (const Pose2& pose : loop_world::laps(0.9)) lap.add(pose, open);
  EXPECT_FALSE(open.knownEnd()) << "there is no loop";
  const double before = std::sqrt(uncertaintiesFrom(open.graph(), 0).back().position_m2);
  for (const Pose2& pose : loop_world::laps(1.4)) laps.add(pose, closed);
  const std::optional<GraphCorrection::Known> end = closed.knownEnd();
  ASSERT_TRUE(end);
  const double after = std::sqrt(end->map_T_keyframe.covariance.topLeftCorner<2, 2>().trace());
  EXPECT_LT(after, 0.3 * before);
  EXPECT_LT(laps.lastError(closed), 4.0 * after);
}

/// Each match is in the motions to and from its keyframe, but only the last one is in the pose.
TEST(SubmapGraph, TheErrorsOfMatchesDoNotAddUp) {
  constexpr double kMatchM2 = 1e-4, kMatchRad2 = 1e-5;
  SubmapGraph exact{MapperConfig(), LoopConfig()}, noisy{MapperConfig(), LoopConfig()};
  Drive one(loop_world::ring(), kYawDrift), other(loop_world::ring(), kYawDrift);
  other.match = Eigen::Vector3d(kMatchM2, kMatchM2, kMatchRad2).asDiagonal();
  for (const Pose2& pose : loop_world::laps(1.4)) {
    one.add(pose, exact);
    other.add(pose, noisy);
  }
  const auto expected = exact.knownEnd(), found = noisy.knownEnd();
  ASSERT_TRUE(expected && found);
  EXPECT_LT(found->map_T_keyframe.covariance.determinant(),
            2.0 * expected->map_T_keyframe.covariance.determinant());
  EXPECT_TRUE(found->local.match_covariance.isZero());
  const std::size_t end = noisy.keyframes().size() - 1;
  const auto of_edges = GraphMarginals(noisy.graph(), {}).between(0, end);
  EXPECT_LT(found->map_T_keyframe.covariance(2, 2), 0.5 * of_edges->covariance(2, 2));
}

/// The map begins with the first keyframe, whose error is that of its frame.
TEST(SubmapGraph, TheErrorOfTheFirstKeyframeLasts) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kYawDrift);
  constexpr double kFirstM2 = 1.0;
  drive.first = Eigen::Vector3d(kFirstM2, kFirstM2, 0.0).asDiagonal();
  for (const Pose2& pose : loop_world::laps(1.4)) drive.add(pose, graph);
  const auto end = graph.knownEnd();
  ASSERT_TRUE(end);
  const Eigen::Matrix3d& covariance = end->map_T_keyframe.covariance;
  EXPECT_GT(covariance(0, 0), kFirstM2);
  EXPECT_GT(covariance(1, 1), kFirstM2);
  EXPECT_LT(covariance(0, 0) + covariance(1, 1), 2.1 * kFirstM2);
}

/// A record does not say which part of an error lasts.
TEST(SubmapGraph, InARecordTheWholeErrorOfAMotionLasts) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  Drive drive(loop_world::ring(), kYawDrift);
  drive.match = 1e-4 * Eigen::Matrix3d::Identity();
  for (const Pose2& pose : loop_world::laps(0.2)) drive.add(pose, graph);
  const SubmapGraph again(MapperConfig(), LoopConfig(), graph.record());
  ASSERT_EQ(again.errors().size(), graph.keyframes().size());
  const PoseEdge& edge = graph.graph().edges[3];
  EXPECT_TRUE(again.errors()[edge.to].lasting.isApprox(edge.information.inverse(), 1e-6));
  EXPECT_LT(graph.errors()[edge.to].lasting(2, 2), 0.5 * again.errors()[edge.to].lasting(2, 2));
}

TEST(GraphCorrection, AddsTheMotionSinceTheKeyframe) {
  const Eigen::Matrix3d match = Eigen::Vector3d(1e-4, 4e-4, 1e-6).asDiagonal();
  GraphCorrection correction;
  correction.map_T_local = Pose2(5.0, 0.0, kPi / 2);
  MapperResult result;
  result.pose = Pose2(10.0, 0.0, 0.0);
  result.uncertain = {result.pose, 100.0 * match, match};
  result.covariance = result.uncertain.covariance();
  const MapperResult without = correction.inMap(result);
  EXPECT_NEAR(without.covariance(1, 1), 101e-4, 1e-9) << "turned";
  correction.known =
      GraphCorrection::Known{{correction.map_T_local * Pose2(8.0, 0.0, 0.0), 10.0 * match},
                             {Pose2(8.0, 0.0, 0.0), 100.0 * match, Eigen::Matrix3d::Zero()}};
  const MapperResult with = correction.inMap(result);
  EXPECT_EQ(with.pose, correction.map_T_local * result.pose);
  EXPECT_NEAR(with.covariance(1, 1), 11e-4, 1e-9) << "keyframe and match; both walls are the same";
  EXPECT_NEAR(with.covariance(0, 0), 48.5e-4, 1e-4) << "the yaw of both turns the 2 m between";
}

TEST(SubmapGraph, ScansThatWereNotInsertedAreIgnored) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  graph.add(room::scanFrom(Pose2()), MapperResult());
  graph.finish();
  EXPECT_TRUE(graph.keyframes().empty());
  EXPECT_EQ(graph.mapTLocal(), Pose2());
}

}  // namespace
}  // namespace kestrel
