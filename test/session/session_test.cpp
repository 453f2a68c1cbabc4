// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/session.h"

#include <gtest/gtest.h>

#include <cmath>

#include "session/session_samples.h"

namespace kestrel {
namespace {

TEST(Session, KeyframesMoveWithTheirSubmap) {
  Session session = sampleSession();
  const std::vector<Pose2> before = keyframePoses(session);
  const Pose2 moved(3.0, -2.0, 1.0);
  session.submaps[1].map_T_submap = moved * session.submaps[1].map_T_submap;
  const std::vector<Pose2> after = keyframePoses(session);
  EXPECT_EQ(after[2], before[2]);
  const Pose2 expected = moved * before[3];
  EXPECT_NEAR(after[3].x, expected.x, 1e-12);
  EXPECT_NEAR(after[3].y, expected.y, 1e-12);
  EXPECT_NEAR(after[3].yaw, expected.yaw, 1e-12);
}

TEST(Session, AVertexOfAKeyframeGivesItsPose) {
  Session session = sampleSession();
  const Pose2 optimized(7.0, 8.0, 0.9);
  session.vertices.push_back({VertexKind::kKeyframe, 101, {optimized, false}});
  EXPECT_EQ(problemOf(session), "");
  EXPECT_EQ(keyframePoses(session)[1], optimized);
  session.submaps.clear();
  session.vertices.erase(session.vertices.begin(), session.vertices.begin() + 2);
  session.edges.clear();
  session.loops.clear();
  removeDangling(session);
  EXPECT_EQ(session.keyframes.size(), 1U);
  EXPECT_EQ(keyframePoses(session)[0], optimized);
}

TEST(Session, TheMapOfTheKeyframesIsTheRoom) {
  const MapSnapshot map = mapOf(sampleSession(3, 720), OccupancyGridConfig());
  EXPECT_NEAR(map.width * map.resolution_m, 8.0, 0.3);
  EXPECT_NEAR(map.height * map.resolution_m, 6.0, 0.3);
}

/// A flight that was not found in the map of the session lies anywhere in it.
TEST(Session, TheMapIsTheLargestPartOfTheGraph) {
  Session session = sampleSession(5);
  EXPECT_EQ(partCount(session), 1U);
  EXPECT_EQ(mapKeyframes(session).size(), 15U);
  session.edges.erase(session.edges.begin() + 1);
  EXPECT_EQ(partCount(session), 2U);
  const std::vector<PlacedKeyframe> map = mapKeyframes(session);
  ASSERT_EQ(map.size(), 9U);
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_EQ(map[i].keyframe->id, 106 + i);
    EXPECT_EQ(map[i].map_T_base, keyframePoses(session)[6 + i]);
  }
  session.edges.clear();
  EXPECT_EQ(mapKeyframes(session).size(), 15U);
}

TEST(Session, RemovesWhatRefersToNothing) {
  Session session = sampleSession(4);
  session.submaps.erase(session.submaps.begin() + 1);
  EXPECT_NE(problemOf(session), "");
  removeDangling(session);
  EXPECT_EQ(problemOf(session), "");
  EXPECT_EQ(session.keyframes.size(), 9U);
  EXPECT_EQ(session.vertices.size(), 3U);
  ASSERT_EQ(session.edges.size(), 1U);
  EXPECT_EQ(session.vertices[session.edges[0].from].id, 12U);
  EXPECT_EQ(session.vertices[session.edges[0].to].id, 13U);
  EXPECT_EQ(session.loops.size(), 2U);
  EXPECT_EQ(session.odometry.size(), 6U);
}

TEST(Session, AnImpossibleHeightIsAProblem) {
  for (const ScanHeight& height : {ScanHeight{-1.0F, {0.0F, 0.0F}}, ScanHeight{NAN, {0.0F, 0.0F}},
                                   ScanHeight{1.0F, {0.0F, NAN}}}) {
    Session session = sampleSession();
    session.keyframes[2] = atHeight(*session.keyframes[2], height);
    EXPECT_EQ(problemOf(session), "keyframe 2: its height is not possible");
  }
}

TEST(Session, RemovesKeyframesThatAreInNoSubmap) {
  Session session = sampleSession(4);
  const std::size_t count = session.keyframes.size();
  auto newer = std::make_shared<Keyframe>(*session.keyframes.back());
  newer->id = 4711;
  session.keyframes.push_back(newer);
  session.vertices.push_back({VertexKind::kKeyframe, newer->id, {Pose2(), false}});
  ASSERT_EQ(problemOf(session), "");
  removeUnplaced(session);
  EXPECT_EQ(problemOf(session), "");
  EXPECT_EQ(session.keyframes.size(), count);
  EXPECT_EQ(session.vertices.size(), sampleSession(4).vertices.size());
}

TEST(Session, OdometryWithoutItsKeyframeOrPoseIsAProblem) {
  Session session = sampleSession();
  session.odometry[1].own = 2;
  EXPECT_EQ(problemOf(session), "odometry 1: it has no pose of its keyframe");
  session.odometry[1].keyframe = 7;
  EXPECT_EQ(problemOf(session), "odometry 1: its keyframe does not exist");
  session = sampleSession();
  session.odometry[0].odom_T_base[0].x = 5e5;  // as from a GPS
  EXPECT_EQ(problemOf(session), "");
  session.odometry[0].odom_T_base[0].x = std::nan("");
  EXPECT_EQ(problemOf(session), "odometry 0: a pose is not finite");
}

}  // namespace
}  // namespace kestrel
