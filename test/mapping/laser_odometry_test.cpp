// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/laser_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kPause = 0.2;  // s
/// A hall with oblique walls and three pillars.
const std::vector<room::Segment> kOtherRoom = {
    {-7, -5, 1, -9}, {1, -9, 9, -2},     {9, -2, 6, 7},    {6, 7, -5, 8},
    {-5, 8, -7, -5}, {-4, -4, -3, -3.5}, {3, -5, 3.5, -4}, {-3, 4, -2, 5}};

PlanarScan scanAt(const Pose2& pose, double time, const std::vector<room::Segment>& walls) {
  PlanarScan scan = room::scanFrom(pose, walls);
  scan.stamp = scan.time = time;
  return scan;
}

/// A slow motion through the middle of the room.
Pose2 truthAt(double time) { return {-1.0 + 0.5 * time, 0.2 * std::sin(0.5 * time), 0.1 * time}; }

double error(const Pose2& found, const Pose2& truth) {
  return (truth.inverse() * found).distance();
}

TEST(LaserOdometry, MeasuresTheMotionFromScansAlone) {
  LaserOdometry odometry{MapperConfig()};
  odometry.begin(scanAt(truthAt(0.0), 0.0, kOtherRoom), truthAt(0.0), true);
  for (int i = 1; i <= 20; ++i) {
    const double time = i * kPause;
    ASSERT_TRUE(odometry.follow(scanAt(truthAt(time), time, kOtherRoom))) << i;
    EXPECT_LT(error(odometry.pose(), truthAt(time)), 0.03) << i;
  }
  EXPECT_LT(error(odometry.pose(), truthAt(20 * kPause)), 0.03);
  EXPECT_LT(odometry.error().position_m(), 0.2);
}

TEST(LaserOdometry, DoesNotFollowAScanOfAnotherPlace) {
  LaserOdometry odometry{MapperConfig()};
  EXPECT_FALSE(odometry.follow(scanAt(Pose2(), 0.0, kOtherRoom)));
  odometry.begin(scanAt(Pose2(), 0.0, kOtherRoom), Pose2(), false);
  const std::vector<room::Segment> cabin = {{-1, -1, 1, -1}, {1, -1, 0, 1}, {0, 1, -1, -1}};
  EXPECT_FALSE(odometry.follow(scanAt(Pose2(), kPause, cabin)));
}

/// A scan of an object that covers the laser.
PlanarScan coveredScan(double time) {
  PlanarScan scan = scanAt(Pose2(), time, room::walls());
  for (PlanarRay& ray : scan.rays) ray.end = 0.4F * ray.end.normalized();
  return scan;
}

/// A mapper that has seen the room of room.h until `end`. Its map is in the frame of room.h.
Mapper mapperUntil(double end) {
  Mapper mapper{MapperConfig()};
  mapper.reset(truthAt(0.0));
  for (double time = 0.0; time < end - 0.5 * kPause; time += kPause)
    mapper.process(scanAt(truthAt(time), time, room::walls()));
  return mapper;
}

/// In one scan, half of the beams see the room and the others something new. Then nothing of the
/// room is seen any more.
TEST(LaserOdometry, CarriesThePoseWhereTheViewChanges) {
  const double changed = 2.0;
  Mapper mapper = mapperUntil(changed);
  PlanarScan half = scanAt(truthAt(changed), changed, room::walls());
  const PlanarScan other = scanAt(truthAt(changed), changed, kOtherRoom);
  for (std::size_t i = 0; i < half.rays.size() / 2; ++i) half.rays[i] = other.rays[i];
  mapper.process(half);
  for (int i = 1; i <= 20; ++i) {
    const double time = changed + i * kPause;
    const MapperResult result = mapper.process(scanAt(truthAt(time), time, kOtherRoom));
    EXPECT_NE(result.state, MatchState::kLost) << i;
    EXPECT_LT(error(result.pose, truthAt(time)), 0.1) << i;
  }
}

/// An object that covers the laser moves with the vehicle. It must not become a part of the map.
TEST(LaserOdometry, ACoverIsNotInserted) {
  const double covered = 2.0;
  Mapper mapper = mapperUntil(covered);
  for (int i = 0; i < 60; ++i) {
    const MapperResult result = mapper.process(coveredScan(covered + i * kPause));
    EXPECT_FALSE(result.inserted) << i;
    if (i == 0) continue;  // the first one is carried
    EXPECT_EQ(result.state, MatchState::kLost) << i;
  }
}

}  // namespace
}  // namespace kestrel
