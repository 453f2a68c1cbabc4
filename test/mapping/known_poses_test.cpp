// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

MapperConfig knownPoses() {
  MapperConfig config;
  config.known_poses = true;
  config.window.enabled = true;  // has no effect then
  return config;
}

/// A scan of the room whose sweep ends at `time`.
PlanarScan scanAt(const Pose2& pose, double time) {
  PlanarScan scan = room::scanFrom(pose);
  scan.time = scan.stamp = time;
  return scan;
}

TEST(KnownPosesTest, ThePoseIsTheGivenOne) {
  Mapper mapper(knownPoses());
  const Pose2 map_T_room(3.0, -2.0, 0.4);
  for (int i = 0; i < 20; ++i) {
    const Pose2 pose(0.1 * i, 0.02 * i, 0.05 * i);
    const MapperResult result = mapper.process(scanAt(pose, 0.1 * i), map_T_room * pose);
    EXPECT_EQ(result.pose, map_T_room * pose);
    EXPECT_EQ(result.state, MatchState::kOk) << i << " " << result.match.score;
    EXPECT_TRUE(result.isMatched());
  }
}

TEST(KnownPosesTest, AWrongPoseIsKeptAndCalledDegraded) {
  Mapper mapper(knownPoses());
  mapper.process(scanAt(Pose2(), 0.0), Pose2());
  const Pose2 wrong(0.6, 0.5, 0.2);
  const MapperResult result = mapper.process(scanAt(Pose2(), 0.1), wrong);
  EXPECT_EQ(result.pose, wrong);
  EXPECT_EQ(result.state, MatchState::kDegraded);
  EXPECT_STREQ(result.reason, "poor fit");
  EXPECT_TRUE(result.inserted);
}

TEST(KnownPosesTest, AScanWithoutAPoseIsNotMapped) {
  Mapper mapper(knownPoses());
  const MapperResult first = mapper.process(scanAt(Pose2(), 0.0));
  EXPECT_EQ(first.state, MatchState::kLost);
  EXPECT_STREQ(first.reason, "no known pose");
  EXPECT_FALSE(first.inserted);
  EXPECT_TRUE(mapper.process(scanAt(Pose2(), 0.1), Pose2()).inserted);
  EXPECT_FALSE(mapper.process(scanAt(Pose2(1.0, 0.0, 0.0), 0.2)).inserted);
}

TEST(KnownPosesTest, ScansWithoutHitsKeepThePose) {
  Mapper mapper(knownPoses());
  PlanarScan blank = scanAt(Pose2(), 0.0);
  blank.rays.clear();
  EXPECT_EQ(mapper.process(blank, Pose2()).state, MatchState::kLost);
  mapper.process(scanAt(Pose2(), 0.1), Pose2());
  blank.time = 0.2;
  EXPECT_EQ(mapper.process(blank, Pose2(1.0, 0.0, 0.0)).pose, Pose2(1.0, 0.0, 0.0));
}

}  // namespace
}  // namespace kestrel
