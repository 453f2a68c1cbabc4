// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/session/graph_session.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "graph/loop_world.h"
#include "kestrel_slam/session/session_file.h"
#include "session/session_samples.h"

namespace kestrel {
namespace {

constexpr double kCell = 0.05;

GraphRecord flownRecord(double laps) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  loop_world::Drive drive(loop_world::ring(), 0.0003);
  for (const Pose2& pose : loop_world::laps(laps)) drive.add(pose, graph);
  graph.finish();
  return graph.record();
}

std::string bytesOf(const GraphRecord& record) {
  Session session = sessionOf(record, kCell);
  session.written_by = "kestrel_slam test";
  return encodeSession(session);
}

/// Through the file and through a graph.
TEST(GraphSession, ComesBackBitByBit) {
  const GraphRecord flown = flownRecord(1.4);
  const std::string bytes = bytesOf(flown);
  const GraphRecord loaded = graphRecordOf(decodeSession(bytes), kCell);
  ASSERT_GT(loaded.loops.size(), 10U);
  ASSERT_GT(loaded.places.size(), 3U);
  for (std::size_t i = 0; i < flown.keyframes.size(); ++i)
    ASSERT_EQ(loaded.keyframes[i].submap, flown.keyframes[i].submap);
  const SubmapGraph graph{MapperConfig(), LoopConfig(), loaded};
  EXPECT_EQ(bytesOf(graph.record()), bytes);
  EXPECT_EQ(graph.loops().back().reason, flown.loops.back().reason);
  EXPECT_EQ(graph.loops().front().fit, flown.loops.front().fit);
}

/// Another flight; returns how the last keyframe of the first flight then lies to its first one.
Pose2 fliesOn(SubmapGraph& graph) {
  const std::size_t last = graph.keyframes().size() - 1;
  graph.beginPart(givenStart(Pose2()));
  loop_world::Drive drive(loop_world::ring(), 0.0);
  for (const Pose2& pose : loop_world::laps(0.3)) drive.add(pose, graph);
  EXPECT_TRUE(graph.isJoined(0));
  return graph.poseOf(0).between(graph.poseOf(last));
}

/// The old part moves as it would if the program had not ended meanwhile.
TEST(GraphSession, TheOdometryOfAnEarlierFlightStillHoldsItsPart) {
  SubmapGraph unbroken{MapperConfig(), LoopConfig()};
  loop_world::Drive drive(loop_world::ring(), 0.0003);
  drive.with_odometry = true;
  for (const Pose2& pose : loop_world::laps(0.9)) drive.add(pose, unbroken);
  const GraphRecord flown = unbroken.record();
  ASSERT_GT(flown.odometry.size(), 30U);
  const std::string bytes = bytesOf(flown);
  const Pose2 expected = fliesOn(unbroken);
  const auto differenceAfterLoading = [&](bool keep) {
    GraphRecord record = graphRecordOf(decodeSession(bytes), kCell);
    EXPECT_EQ(record.odometry.size(), flown.odometry.size());
    if (!keep) record.odometry.clear();
    SubmapGraph graph{MapperConfig(), LoopConfig(), std::move(record)};
    EXPECT_EQ(bytesOf(graph.record()) == bytes, keep);
    return expected.between(fliesOn(graph)).distance();
  };
  EXPECT_LT(differenceAfterLoading(true), 1e-3);
  EXPECT_GT(differenceAfterLoading(false), 0.02);
}

TEST(GraphSession, AnEmptyGraphIsASession) {
  const SubmapGraph empty{MapperConfig(), LoopConfig()};
  const Session session = decodeSession(bytesOf(empty.record()));
  EXPECT_FALSE(startAtEnd(session));
  SubmapGraph graph{MapperConfig(), LoopConfig(), graphRecordOf(session, kCell)};
  graph.beginPart(std::nullopt);
  loop_world::Drive drive(loop_world::ring(), 0.0);
  for (const Pose2& pose : loop_world::laps(0.1)) drive.add(pose, graph);
  EXPECT_EQ(problemOf(sessionOf(graph.record(), kCell)), "");
}

/// A loaded graph goes on, is saved and loaded again.
TEST(GraphSession, SeveralFlightsAreOneSession) {
  GraphRecord record = flownRecord(0.4);
  for (int flight = 0; flight < 2; ++flight) {
    const std::string bytes = bytesOf(record);
    SubmapGraph graph{MapperConfig(), LoopConfig(), graphRecordOf(decodeSession(bytes), kCell)};
    graph.beginPart(givenStart(Pose2()));
    loop_world::Drive drive(loop_world::ring(), 0.0001 * flight);
    for (const Pose2& pose : loop_world::laps(0.4)) drive.add(pose, graph);
    graph.finish();
    EXPECT_TRUE(graph.isJoined(0));
    record = graph.record();
  }
  const std::string bytes = bytesOf(record);
  const SubmapGraph graph{MapperConfig(), LoopConfig(), graphRecordOf(decodeSession(bytes), kCell)};
  EXPECT_EQ(bytesOf(graph.record()), bytes);
  EXPECT_TRUE(graph.isJoined(0));
}

/// The second flight was given a wrong start, and no loop joined it.
TEST(GraphSession, AFlightThatWasNotFoundIsNotInTheMap) {
  const GraphRecord first = flownRecord(0.6);
  SubmapGraph graph{MapperConfig(), LoopConfig(), first};
  const Pose2 far_away(500.0, 0.0, 0.0);
  graph.beginPart(givenStart(far_away));
  loop_world::Drive drive(loop_world::ring(), 0.0001, far_away);
  for (const Pose2& pose : loop_world::laps(0.1)) drive.add(pose, graph);
  graph.finish();
  ASSERT_FALSE(graph.isJoined(0));
  const Session session = sessionOf(graph.record(), kCell);
  EXPECT_EQ(partCount(session), 2U);
  EXPECT_GT(session.keyframes.size(), first.keyframes.size());
  EXPECT_EQ(mapKeyframes(session).size(), first.keyframes.size());
  EXPECT_EQ(mapKeyframes(graph.record()).size(), first.keyframes.size());
  const MapSnapshot before = mapOf(sessionOf(first, kCell), OccupancyGridConfig());
  const MapSnapshot after = mapOf(session, OccupancyGridConfig());
  EXPECT_EQ(after.width, before.width);
  EXPECT_EQ(after.height, before.height);
}

std::string refusalOf(const Session& session, double resolution_m) {
  try {
    graphRecordOf(session, resolution_m);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(GraphSession, OtherSessionsAreRefused) {
  EXPECT_EQ(refusalOf(sampleSession(), kCell),
            "this session cannot be continued: its vertices are not its keyframes");
  EXPECT_EQ(refusalOf(sampleSession(), 0.1),
            "this session cannot be continued: it has cells of 0.05 m, and map_resolution is 0.1; "
            "set map_resolution to 0.05");
  Session session = sessionOf(flownRecord(0.6), kCell);
  std::swap(session.submaps[1].keyframes[0], session.submaps[1].keyframes[1]);
  EXPECT_EQ(refusalOf(session, kCell),
            "this session cannot be continued: the keyframes of submap 1 are not consecutive");
  session.submaps.erase(session.submaps.begin());
  session.submaps.erase(session.submaps.begin());
  EXPECT_NE(refusalOf(session, kCell).find("is in no submap"), std::string::npos);
}

TEST(GraphSession, StatisticsAddUp) {
  Session session;
  addStatistic(session, "scans", 3.0);
  addStatistic(session, "distance_m", 1.5);
  addStatistic(session, "scans", 4.0);
  ASSERT_EQ(session.statistics.size(), 2U);
  EXPECT_EQ(session.statistics[0].value, 7.0);
}

}  // namespace
}  // namespace kestrel
