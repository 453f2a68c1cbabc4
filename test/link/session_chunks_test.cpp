// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/link/session_chunks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../session/session_samples.h"
#include "kestrel_slam/session/session_file.h"

namespace kestrel {
namespace {

/// A flight along the room, with a graph of keyframes.
Session flight(std::size_t keyframes) {
  Session session;
  session.resolution_m = 0.05;
  for (std::size_t i = 0; i < keyframes; ++i) {
    const Pose2 pose(0.01 * static_cast<double>(i), 0.2, 0.1);
    const ScanHeight height{1.0F + 0.01F * static_cast<float>(i), {0.1F, 0.0F}};
    session.keyframes.push_back(atHeight(*sampleKeyframe(i, pose, Pose2(), 30), height));
    session.vertices.push_back({VertexKind::kKeyframe, i, {pose, i == 0}});
    if (i > 0)
      session.edges.push_back(
          {i - 1, i, Pose2(0.01, 0.0, 0.0), sampleMatrix(1e4), EdgeKind::kOdometry});
  }
  return session;
}

TEST(SessionChunks, AGrowingSessionArrives) {
  ChunkJournal journal("", {"uav0", 1});
  SessionCutter cutter(journal);
  for (std::size_t count = 5; count <= 200; count += 5) cutter.update(flight(count));
  const Session session = assembledSession(journal);
  EXPECT_EQ(problemOf(session), "");
  ASSERT_EQ(session.keyframes.size(), 200U);
  EXPECT_EQ(session.edges.size(), 199U);
  const std::vector<Pose2> sent = keyframePoses(flight(200)), received = keyframePoses(session);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_LT(sent[i].between(received[i]).distance(), 1e-9);
    EXPECT_TRUE(session.keyframes[i]->scan == flight(200).keyframes[i]->scan);
    EXPECT_EQ(session.keyframes[i]->height.base_m, flight(200).keyframes[i]->height.base_m);
    EXPECT_EQ(session.keyframes[i]->height.slope.x(), 0.1F);
  }
}

TEST(SessionChunks, TheTrafficIsProportionalToTheKeyframes) {
  ChunkJournal journal("", {"uav0", 1});
  SessionCutter cutter(journal);
  std::size_t poses = 0;
  for (std::size_t count = 5; count <= 400; count += 5) cutter.update(flight(count));
  std::size_t chunks = 0;
  for (std::uint64_t i = 1; i <= journal.last(); ++i) {
    if (journal.get(i)->key != 0) ++poses;
    ++chunks;
  }
  EXPECT_LT(poses, 20U) << "of " << chunks;
}

TEST(SessionChunks, ARestartedCutterGoesOn) {
  ChunkJournal journal("", {"uav0", 1});
  SessionCutter(journal).update(flight(50));
  const std::uint64_t before = journal.last();
  SessionCutter(journal).update(flight(50));
  EXPECT_EQ(journal.last(), before);
  SessionCutter(journal).update(flight(60));
  EXPECT_EQ(journal.last(), before + 1);
}

TEST(SessionChunks, MissingChunksLeaveTheRest) {
  ChunkJournal all("", {"uav0", 1}), some("", {"uav0", 1});
  SessionCutter(all).update(flight(100), true);
  for (std::uint64_t i = 1; i <= all.last(); ++i) {
    if (i % 3 != 1) some.add(*all.get(i));
  }
  some.add({all.last() + 1, 0, "no session"});
  std::size_t damaged = 0;
  const Session session = assembledSession(some, &damaged);
  EXPECT_EQ(problemOf(session), "");
  EXPECT_GT(session.keyframes.size(), 50U);
  EXPECT_LT(session.keyframes.size(), 100U);
  EXPECT_EQ(damaged, 1U);
}

/// A flight whose poses do not fit into one chunk, and are not those of its odometry.
Session longFlight(std::size_t keyframes, double bend) {
  Session session = flight(keyframes);
  for (std::size_t i = 0; i < keyframes; ++i) {
    Pose2& pose = session.vertices[i].vertex.pose;
    pose = pose * Pose2(0.0, bend * std::sin(0.01 * static_cast<double>(i)), 0.0);
  }
  session.edges.push_back({0, keyframes - 1, Pose2(), sampleMatrix(1e4), EdgeKind::kLoop});
  return session;
}

double largestError(const Session& sent, const Session& received) {
  const std::vector<Pose2> a = keyframePoses(sent), b = keyframePoses(received);
  EXPECT_EQ(a.size(), b.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    largest = std::max(largest, a[i].between(b[i]).distance());
  return largest;
}

TEST(SessionChunks, ThePosesOfALongFlightArrive) {
  ChunkJournal journal("", {"uav0", 1});
  const Session first = longFlight(6000, 0.3), second = longFlight(8000, 0.6);
  SessionCutter(journal).update(first);
  EXPECT_LT(largestError(first, assembledSession(journal)), 1e-9);
  SessionCutter(journal).update(second);  // after a restart
  std::size_t damaged = 0;
  const Session received = assembledSession(journal, &damaged);
  EXPECT_EQ(problemOf(received), "");
  EXPECT_LT(largestError(second, received), 1e-9);
  EXPECT_EQ(received.edges.size(), 8000U) << "the loop, too";
  EXPECT_EQ(damaged, 0U);
  for (std::uint64_t i = 1; i <= journal.last(); ++i)
    EXPECT_LT(journal.get(i)->content.size(), 100'000U) << "a slow link must carry each at once";
}

TEST(SessionChunks, WhilePosesAreMissingThoseBeforeAreUsed) {
  ChunkJournal all("", {"uav0", 1});
  const Session first = longFlight(6000, 0.3);
  SessionCutter cutter(all);
  cutter.update(first);
  const std::uint64_t then = all.last();
  cutter.update(longFlight(6000, 0.6), true);
  ASSERT_GT(all.last(), then + 2);
  ChunkJournal some("", {"uav0", 1});
  for (std::uint64_t i = 1; i <= all.last(); ++i) {
    if (i != then + 1) some.add(*all.get(i));
  }
  EXPECT_LT(largestError(first, assembledSession(some)), 1e-9);
  EXPECT_EQ(assembledSession(some).edges.size(), 6000U) << "the loop, too";
}

TEST(SessionChunks, OneFlightHasOneEpoch) {
  EXPECT_EQ(epochOf(flight(10)), epochOf(flight(20)));
  Session other = flight(10);
  other.keyframes.erase(other.keyframes.begin());
  EXPECT_NE(epochOf(other), epochOf(flight(10)));
}

}  // namespace
}  // namespace kestrel
