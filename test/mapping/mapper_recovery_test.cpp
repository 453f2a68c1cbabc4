// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kScanTime = 0.025;  // s
/// The prediction by the velocity is known to be in the near window for this number of scans.
constexpr int kCarried = 12;

/// A scan of the room in which an object at 0.4 m blocks the beams from `first` to `end` of 360.
PlanarScan coveredScan(const Pose2& pose, double time, std::size_t first, std::size_t end) {
  PlanarScan scan = room::scanFrom(pose);
  scan.stamp = scan.time = time;
  for (std::size_t i = first; i < end; ++i) {
    scan.rays[i].end = 0.4F * scan.rays[i].end.normalized();
    scan.rays[i].hit = true;
  }
  return scan;
}

PlanarScan freeScan(const Pose2& pose, double time) { return coveredScan(pose, time, 0, 0); }

/// A mapper with a map of the room, seen from some places around the origin.
Mapper mapperInRoom(double& time) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 100; ++i, time += kScanTime) {
    const double along = 0.01 * i;
    mapper.process(freeScan(Pose2(-along, 0.3 * along, 0.3 * along), time));
  }
  return mapper;
}

TEST(MapperRecovery, ABlockedHalfOfTheViewDoesNotMoveThePose) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  const MapSnapshot before = mapper.snapshot();
  for (int i = 0; i < 40; ++i, time += kScanTime) {
    const Pose2 truth(-1.0 + 0.01 * i, 0.3, 0.3);
    const MapperResult result = mapper.process(coveredScan(truth, time, 90, 270));
    EXPECT_NE(result.state, MatchState::kLost) << i;
    EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.06) << i;
  }
  const auto occupied = [](const MapSnapshot& map) {
    return std::count(map.cells.begin(), map.cells.end(), MapSnapshot::kOccupied);
  };
  EXPECT_LT(occupied(mapper.snapshot()), occupied(before) + 60);
}

TEST(MapperRecovery, AMotionThatIsNotPossibleIsSaid) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  const Pose2 jumped(-0.9, 0.4, 0.3);  // 0.14 m in one scan
  MapperResult result = mapper.process(freeScan(jumped, time));
  EXPECT_NEAR((jumped.inverse() * result.pose).distance(), 0.0, 0.03);
  EXPECT_EQ(result.state, MatchState::kDegraded);
  EXPECT_STREQ(result.reason, "impossible motion");
  for (int i = 0; i < 20; ++i) result = mapper.process(freeScan(jumped, time += kScanTime));
  EXPECT_EQ(result.state, MatchState::kOk);
}

/// As when a laser that tilts sees the floor: an impossible motion, and then scans that contradict
/// the map in a fifth of the beams.
TEST(MapperRecovery, ADoubtfulPoseIsSaidAndTeachesTheMapNothing) {
  constexpr std::size_t kFirst = 90, kEnd = 160;
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  MapperResult result = mapper.process(freeScan(Pose2(-1.1, 0.4, 0.3), time));
  ASSERT_STREQ(result.reason, "impossible motion");
  EXPECT_TRUE(result.doubtful);
  const double sure = result.covariance(0, 0);
  for (int i = 1; i < 10; ++i) {
    const Pose2 truth(-1.1, 0.4 - 0.06 * i, 0.3);
    result = mapper.process(coveredScan(truth, time += kScanTime, kFirst, kEnd));
    EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.05) << i;
    EXPECT_TRUE(result.doubtful) << i;
    EXPECT_FALSE(result.inserted) << i;
  }
  EXPECT_GT(result.covariance(0, 0), sure + 0.03 * 0.03) << "the error since then";
  for (int i = 0; i < 30; ++i)
    result = mapper.process(freeScan(Pose2(-1.1, -0.14, 0.3), time += kScanTime));
  EXPECT_EQ(result.state, MatchState::kOk);
  EXPECT_FALSE(result.doubtful);
  EXPECT_LT(result.covariance(0, 0), 0.01 * 0.01);
}

/// New space is mapped in doubt, too, or else the vehicle would be lost in it.
TEST(MapperRecovery, InDoubtNewSpaceIsMapped) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  ASSERT_TRUE(mapper.process(freeScan(Pose2(-1.1, 0.4, 0.3), time)).doubtful);
  bool inserted = false;
  for (int i = 1; i < 9; ++i) {
    PlanarScan scan = freeScan(Pose2(-1.1, 0.4 - 0.06 * i, 0.3), time += kScanTime);
    for (std::size_t k = 90; k < 160; ++k) scan.rays[k].end *= 2.0F;  // through a door
    const MapperResult result = mapper.process(scan);
    EXPECT_TRUE(result.doubtful) << i;
    inserted = inserted || result.inserted;
  }
  EXPECT_TRUE(inserted);
}

TEST(MapperRecovery, IsLostWithABlockedViewAndRecoversFarAway) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  for (int i = 0; i < 80; ++i, time += kScanTime) {
    const MapperResult result = mapper.process(coveredScan(Pose2(), time, 0, 360));
    // The first ones are carried by the velocity.
    EXPECT_EQ(result.state, i < kCarried ? MatchState::kDegraded : MatchState::kLost) << i;
    EXPECT_FALSE(result.inserted) << i;
  }
  const Pose2 truth(1.6, -1.8, 1.4);  // 3.3 m and 1.1 rad away, after 2 s
  const MapperResult result = mapper.process(freeScan(truth, time));
  EXPECT_NE(result.state, MatchState::kLost);
  EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.03);
  EXPECT_NEAR(normalizeAngle(result.pose.yaw - truth.yaw), 0.0, 0.02);
}

/// A hand over the laser, and a round column near the vehicle: the circle of returns fits the
/// column.
TEST(MapperRecovery, AHandOverTheLaserIsNotAColumn) {
  double time = 0.0;
  const auto scanAt = [&](const Pose2& pose) {
    PlanarScan scan = freeScan(pose, time += 0.1);
    for (double angle = 0.0; angle < 2.0 * kPi; angle += 0.05) {
      const Eigen::Vector2d on_column(1.2 + 0.25 * std::cos(angle), 1.0 + 0.25 * std::sin(angle));
      const Eigen::Vector2d point = pose.inverse() * on_column;
      scan.rays.push_back({Eigen::Vector2f::Zero(), point.cast<float>(), true});
    }
    return scan;
  };
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 30; ++i) mapper.process(scanAt(Pose2(0.01 * i, 0, 0)));
  const Pose2 last(0.3, 0, 0);
  for (int i = 0; i < 40; ++i) {
    PlanarScan hand = freeScan(last, time += 0.1);
    for (PlanarRay& ray : hand.rays) ray = {ray.origin, 0.25F * ray.end.normalized(), true};
    const MapperResult result = mapper.process(hand);
    EXPECT_NE(result.state, MatchState::kOk) << i;
    if (result.state != MatchState::kLost) {
      EXPECT_LT(last.between(result.pose).distance(), 0.5) << i;
    }
  }
}

TEST(MapperRecovery, RecoversAfterSecondsWithoutScans) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  time += 2.0;
  const Pose2 truth(1.6, -1.8, 2.4);
  const MapperResult result = mapper.process(freeScan(truth, time));
  EXPECT_NE(result.state, MatchState::kLost);
  EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.03);
}

/// A fast vehicle stops while no scan arrives: it is not where the velocity leads.
TEST(MapperRecovery, GoesOnAfterAPauseOfTwentySeconds) {
  constexpr double kClock = 1.7e9, kPeriod = 0.1, kStepM = 0.25;
  Mapper mapper{MapperConfig()};
  mapper.reset(Pose2(-1.5, 0, 0));
  double time = kClock;
  Pose2 truth(-1.5, 0, 0);
  for (int i = 0; i < 10; ++i, truth.x += kStepM) mapper.process(freeScan(truth, time += kPeriod));
  time += 20.0;
  for (int i = 0; i < 3; ++i, truth.x += 0.1) {
    const MapperResult result = mapper.process(freeScan(truth, time += kPeriod));
    EXPECT_EQ(result.state, MatchState::kDegraded) << i;
    EXPECT_NEAR((truth.inverse() * result.pose).distance(), 0.0, 0.05) << i;
  }
}

TEST(MapperRecovery, DoesNotMatchAnotherRoom) {
  double time = 0.0;
  Mapper mapper = mapperInRoom(time);
  for (int i = 0; i < 8; ++i, time += kScanTime) {
    mapper.process(coveredScan(Pose2(), time, 0, 360));
  }
  const std::vector<room::Segment> other = {
      {-1, -9, 2, -7}, {2, -7, 2.5, 1}, {2.5, 1, -2, 2}, {-2, 2, -1, -9}};
  for (int i = 8; i < 24; ++i, time += kScanTime) {
    PlanarScan scan = room::scanFrom(Pose2(), other);
    scan.stamp = scan.time = time;
    const MapperResult result = mapper.process(scan);
    EXPECT_FALSE(result.isMatched()) << i;
    EXPECT_FALSE(result.inserted) << i;
    EXPECT_EQ(result.state, i < kCarried ? MatchState::kDegraded : MatchState::kLost) << i;
  }
}

}  // namespace
}  // namespace kestrel
