// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/localizer.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "../merging/building.h"
#include "rooms.h"

namespace kestrel {
namespace {

using room::Segment;
using rooms::insertAt;
using rooms::moved;
using rooms::otherRoom;

MapperResult process(Localizer& localizer, const Pose2& pose, double time,
                     const std::vector<Segment>& walls = room::walls()) {
  PlanarScan scan = room::scanFrom(pose, walls);
  scan.stamp = scan.time = time;
  return localizer.process(scan);
}

/// The pose after at most `scans` scans at one place.
MapperResult stand(Localizer& localizer, const Pose2& pose, double& time, int scans) {
  MapperResult result;
  for (int i = 0; i < scans; ++i) {
    result = process(localizer, pose, time += 0.1);
    if (result.state != MatchState::kLost) break;
  }
  return result;
}

TEST(Localizer, FindsTracksLosesAndFindsAgain) {
  Localizer localizer(MapperConfig(), room::map());
  double time = 0.0;
  Pose2 truth(1, -1, 2.1);
  MapperResult result = stand(localizer, truth, time, 20);
  ASSERT_NE(result.state, MatchState::kLost);
  EXPECT_LT(truth.between(result.pose).distance(), 0.05);
  const std::size_t scans = static_cast<std::size_t>(localizer.mapper().map().scans());
  for (int i = 0; i < 20; ++i) {
    truth = truth * Pose2(0.03, 0, 0.02);
    result = process(localizer, truth, time += 0.1);
    EXPECT_NE(result.state, MatchState::kLost);
    EXPECT_LT(truth.between(result.pose).distance(), 0.05);
    EXPECT_FALSE(result.inserted);
  }
  const Pose2 carried(-2.5, 1.8, -1.2);
  for (int i = 0; i < 30; ++i) result = process(localizer, carried, time += 0.1);
  EXPECT_LT(carried.between(result.pose).distance(), 0.05);
  EXPECT_EQ(static_cast<std::size_t>(localizer.mapper().map().scans()), scans);
}

TEST(Localizer, TakesThePoseOfAUserAnyNumberOfTimes) {
  Submap map = room::map();
  insertAt(30.0, moved(room::walls(), 30.0), map);
  Localizer localizer(MapperConfig(), std::move(map));
  double time = 0.0;
  EXPECT_EQ(stand(localizer, {1, -1, 2.1}, time, 10).state, MatchState::kLost);  // two equal rooms
  for (const double x : {30.0, 0.0, 30.0}) {
    localizer.setPose(Pose2(x + 1.1, -0.9, 2.15));
    const MapperResult result = process(localizer, {1, -1, 2.1}, time += 0.1);
    EXPECT_LT(Pose2(x + 1, -1, 2.1).between(result.pose).distance(), 0.05);
  }
}

/// The vehicle flies towards an equal room, and turns back while no scan arrives.
TEST(Localizer, IsLostAfterAGapInWhichTheVehicleMayHaveMovedFar) {
  constexpr double kRooms = 20.0, kClock = 1.7e9, kStep = 0.5;
  Submap map = room::map();
  insertAt(kRooms, moved(room::walls(), kRooms), map);
  Localizer localizer(MapperConfig(), std::move(map));
  Pose2 truth(-1.0, -1.0, 0.0);
  double time = kClock, speed = 0.0;
  localizer.setPose(truth);
  for (int i = 0; i < 5; ++i, truth.x += kStep) {
    const MapperResult result = process(localizer, truth, time += 0.1);
    ASSERT_LT(truth.between(result.pose).distance(), 0.05);
    speed = result.velocity.x();
  }
  time += kRooms / speed;
  for (int i = 0; i < 10; ++i) {
    const MapperResult result = process(localizer, truth, time += 0.1);
    EXPECT_EQ(result.state, MatchState::kLost) << result.pose.x << " instead of " << truth.x;
  }
}

/// An equal room that the vehicle cannot have reached is no second explanation.
TEST(Localizer, AfterAGapOnlyPlacesInReachAreExplanations) {
  constexpr double kFar = 100.0, kGap = 3.0;
  Submap map = room::map();
  insertAt(kFar, moved(room::walls(), kFar), map);
  Localizer localizer(MapperConfig(), std::move(map));
  Pose2 truth(-1.0, -1.0, 0.0);
  double time = 1.7e9;
  localizer.setPose(truth);
  for (int i = 0; i < 10; ++i, truth.x += 0.05) process(localizer, truth, time += 0.1);
  truth = Pose2(1.5, 0.8, 2.0);
  time += kGap;
  const MapperResult result = stand(localizer, truth, time, 20);
  ASSERT_NE(result.state, MatchState::kLost) << localizer.answer().reason;
  EXPECT_LT(truth.between(result.pose).distance(), 0.05);
}

/// The vehicle was carried away farther than it can fly in the gap.
TEST(Localizer, AfterAGapTheWholeMapIsSearchedIfThePlacesInReachDoNotFit) {
  constexpr double kFar = 100.0;
  Submap map = room::map();
  insertAt(kFar, moved(otherRoom(), kFar), map);
  Localizer localizer(MapperConfig(), std::move(map));
  double time = 1.7e9;
  localizer.setPose({1, -1, 2.1});
  for (int i = 0; i < 10; ++i) process(localizer, {1, -1, 2.1}, time += 0.1);
  const Pose2 truth(kFar - 0.5, 0.3, 1.1);
  time += 3.0;
  MapperResult result;
  for (int i = 0; i < 40; ++i) {
    result = process(localizer, truth, time += 0.1, moved(otherRoom(), kFar));
    if (result.state != MatchState::kLost) break;
  }
  ASSERT_NE(result.state, MatchState::kLost) << localizer.answer().reason;
  EXPECT_LT(truth.between(result.pose).distance(), 0.05);
}

/// A vehicle that was found in a map of the west, although it is in the east: the corridor looks
/// the same from its other end. Then the map grows.
TEST(Localizer, APoseFromASmallerMapIsCheckedInTheGrownOne) {
  const building::Walls walls = building::walls();
  const std::vector<Pose2> way = building::tour(0, 2);
  const std::vector<Pose2> back(way.rbegin(), way.rend());
  constexpr std::size_t kFirst = 85, kScans = 20;
  const Pose2 half_turn(24.0, 0.0, kPi);
  for (const bool found_right : {false, true}) {
    Submap map{OccupancyGridConfig()};
    for (const Pose2& pose : way) map.insert(room::scanFrom(pose, walls, 180), pose);
    Localizer localizer(MapperConfig(), std::move(map));
    Localizer before(MapperConfig(), room::map());
    const Pose2 moved(3.0, -2.0, 0.5);
    before.setPose(moved.inverse() * (found_right ? back[kFirst] : half_turn * back[kFirst]));
    localizer.continueFrom(before, moved);
    double time = 0.0, error = 0.0;
    for (std::size_t i = kFirst; i < kFirst + kScans; ++i) {
      const MapperResult result = process(localizer, back[i], time += 0.1, walls);
      error = back[i].between(result.pose).distance();
      EXPECT_NE(result.state, MatchState::kLost);
      EXPECT_TRUE(!found_right || error < 0.05) << error;
    }
    EXPECT_LT(error, 0.05);
  }
}

/// A corridor whose walls have pillars up to x = 8 m only, and a laser that sees 4 m.
TEST(Localizer, AfterAGapInACorridorTheMotionGoesOn) {
  constexpr double kSpeed = 1.0, kPeriod = 0.2, kGap = 1.0, kRange = 4.0;
  std::vector<Segment> walls = {{-5, -1, 60, -1}, {-5, 1, 60, 1}};
  for (double x = -4.0; x < 8.0; x += 1.7) {
    walls.push_back({x, -1, x, -0.6});
    walls.push_back({x, -0.6, x + 0.4, -0.6});
    walls.push_back({x + 0.4, -0.6, x + 0.4, -1});
  }
  const auto scanAt = [&](double x, double time) {
    PlanarScan scan = room::scanFrom(Pose2(x, 0, 0), walls, 360, kRange);
    scan.stamp = scan.time = time;
    return scan;
  };
  Submap map{OccupancyGridConfig()};
  for (double x = -4.0; x < 30.0; x += 0.3) map.insert(scanAt(x, 0.0), Pose2(x, 0, 0));
  Localizer localizer(MapperConfig(), std::move(map));
  localizer.setPose(Pose2(2, 0, 0));
  double time = 0.0, x = 2.0;
  for (; x < 12.5; x += kSpeed * kPeriod, time += kPeriod) localizer.process(scanAt(x, time));
  const double begin = localizer.process(scanAt(x += kGap * kSpeed, time += kGap)).pose.x;
  MapperResult result;
  for (int i = 1; i <= 10; ++i)
    result = localizer.process(scanAt(x + i * kSpeed * kPeriod, time + i * kPeriod));
  EXPECT_NEAR(result.pose.x - begin, 10 * kSpeed * kPeriod, 0.5);
}

/// The motion that was measured while the pose was unknown goes on: a gap right after it is seen.
TEST(Localizer, KnowsHowFarItMayBeInAGapAfterItWasFound) {
  const building::Walls walls = building::walls();
  const std::vector<Pose2> way = building::tour(0, 2);
  constexpr std::size_t kBefore = 8, kAfter = 8;
  std::size_t found = 0;
  for (std::size_t start = 0; start < 100; start += 9) {
    for (const std::size_t gap : {12, 24}) {
      Submap map{OccupancyGridConfig()};
      for (const Pose2& pose : way) map.insert(room::scanFrom(pose, walls, 180), pose);
      Localizer localizer(MapperConfig(), std::move(map));
      for (std::size_t i = 0; i < kBefore + kAfter; ++i) {
        const std::size_t at = start + i + (i < kBefore ? 0 : gap);
        const MapperResult result =
            process(localizer, way[at], 0.1 * static_cast<double>(at), walls);
        if (result.state == MatchState::kLost) continue;
        ++found;
        EXPECT_LT(way[at].between(result.pose).distance(), 0.5) << start << ' ' << gap << ' ' << i;
      }
    }
  }
  EXPECT_GT(found, 200U);
}

/// A slow flight through all rooms.
std::vector<Pose2> flight() {
  constexpr int kSteps = 3;
  const std::vector<Pose2> way = building::tour(0, 2);
  std::vector<Pose2> result;
  for (std::size_t i = 1; i < way.size(); ++i) {
    for (int k = 0; k < kSteps; ++k)
      result.push_back(interpolate(way[i - 1], way[i], static_cast<double>(k) / kSteps));
  }
  return result;
}

Submap mapAlong(const std::vector<Pose2>& way, const building::Walls& walls) {
  Submap result{OccupancyGridConfig()};
  for (std::size_t i = 0; i < way.size(); i += 3)
    result.insert(room::scanFrom(way[i], walls, 180), way[i]);
  return result;
}

/// Flies on by so many scans. Returns in how many the vehicle was not lost; there the pose is
/// right.
std::size_t fly(Localizer& localizer, const std::vector<Pose2>& way, std::size_t scans,
                std::size_t& at) {
  static const building::Walls walls = building::walls();
  std::size_t found = 0;
  for (std::size_t i = 0; i < scans; ++i, ++at) {
    const MapperResult result = process(localizer, way[at], 0.1 * static_cast<double>(at), walls);
    if (result.state == MatchState::kLost) continue;
    ++found;
    EXPECT_LT(way[at].between(result.pose).distance(), 0.3) << at;
  }
  return found;
}

/// The vehicle is found by the first scan after a gap, and the next scans are missing, too, or
/// the map is exchanged. Then nothing is known of the interval between scans but what was before.
TEST(Localizer, AGapRightAfterAGapIsNoticed) {
  const std::vector<Pose2> way = flight();
  constexpr std::size_t kBegin = 5, kGap = 25, kEnd = 5;
  std::size_t found = 0;
  for (const bool exchanged : {false, true}) {
    for (std::size_t start = 0; start + 2 * kGap + 2 * kEnd < way.size(); start += 30) {
      auto localizer =
          std::make_unique<Localizer>(MapperConfig(), mapAlong(way, building::walls()));
      localizer->setPose(way[start]);
      std::size_t at = start;
      found += fly(*localizer, way, kBegin, at);
      at += kGap;
      found += fly(*localizer, way, 1, at);
      if (exchanged) {
        auto grown = std::make_unique<Localizer>(MapperConfig(), mapAlong(way, building::walls()));
        grown->continueFrom(*localizer, Pose2());
        localizer = std::move(grown);
      }
      at += kGap;
      found += fly(*localizer, way, kEnd, at);
    }
  }
  EXPECT_GT(found, 100U);
}

/// Scans are missing while the first one is searched for, or right after its place was found. Its
/// place is not that of the next scan.
TEST(Localizer, AGapAfterTheFirstScanIsNoticed) {
  const building::Walls walls = building::walls();
  const std::vector<Pose2> way = flight();
  constexpr std::size_t kScans = 6;
  const double min_fit = RelocalizationConfig().min_fit;
  std::size_t found = 0;
  for (const std::size_t gap : {8, 16, 24}) {
    for (std::size_t start = 0; start + gap + kScans < way.size(); start += 30) {
      Localizer localizer(MapperConfig(), mapAlong(way, walls));
      for (std::size_t i = 0; i < kScans; ++i) {
        const std::size_t at = start + i + (i > 0 ? gap : 0);
        const bool was_lost = localizer.isLost();
        const MapperResult result =
            process(localizer, way[at], 0.1 * static_cast<double>(at), walls);
        if (localizer.isLost()) continue;
        ++found;
        EXPECT_LT(way[at].between(result.pose).distance(), 0.3) << start << ' ' << at;
        EXPECT_TRUE(!was_lost || result.match.score >= min_fit) << start << ' ' << at;
      }
    }
  }
  EXPECT_GT(found, 20U);
}

/// In a log with few scans every step is as long as a gap.
TEST(Localizer, FindsTheVehicleInALogWithFewScans) {
  const std::vector<Pose2> way = flight();
  constexpr std::size_t kEvery = 12;  // 1 m
  Localizer localizer(MapperConfig(), mapAlong(way, building::walls()));
  std::size_t found = 0, scans = 0;
  for (std::size_t at = 0; at < way.size(); at += kEvery - 1, ++scans)
    found += fly(localizer, way, 1, at);
  EXPECT_GT(10 * found, 9 * scans);
}

/// The pose of a user is searched around in the grown map, too.
TEST(Localizer, APoseOfAUserIsKeptIfTheMapIsExchangedBeforeTheNextScan) {
  Localizer before(MapperConfig(), room::map());
  before.setPose({1.1, -0.9, 2.15});
  Submap map = room::map();
  insertAt(30.0, moved(room::walls(), 30.0), map);
  Localizer localizer(MapperConfig(), std::move(map));
  localizer.continueFrom(before, Pose2());
  const Pose2 truth(1, -1, 2.1);
  const MapperResult result = process(localizer, truth, 1.7e9);
  EXPECT_NE(result.state, MatchState::kLost);
  EXPECT_LT(truth.between(result.pose).distance(), 0.05);
}

}  // namespace
}  // namespace kestrel
