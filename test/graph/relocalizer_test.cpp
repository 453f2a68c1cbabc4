// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/relocalizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../merging/building.h"
#include "kestrel_slam/graph/localizer.h"
#include "kestrel_slam/map/picture_map.h"
#include "loop_world.h"

namespace kestrel {
namespace {

using room::Segment;

std::vector<Segment> moved(const std::vector<Segment>& walls, double x) {
  std::vector<Segment> result;
  for (const Segment& s : walls) result.push_back({s.x0 + x, s.y0, s.x1 + x, s.y1});
  return result;
}

/// A room that has no place in common with room::walls().
std::vector<Segment> otherRoom() {
  std::vector<Segment> walls;
  loop_world::addBox(walls, -6, -1.5, 12, 3);
  loop_world::addBox(walls, -1.2, -0.5, 0.5, 0.5);
  loop_world::addBox(walls, 3.1, 0.4, 0.9, 0.3);
  return walls;
}

void insertAt(double x, const std::vector<Segment>& walls, Submap& map) {
  for (const Pose2& pose : {Pose2(0, 0, 0), Pose2(0.5, 0.3, 1), Pose2(-0.6, -0.4, 2)})
    map.insert(room::scanFrom(Pose2(x, 0, 0) * pose, walls), Pose2(x, 0, 0) * pose);
}

RelocalizationQuery queryOf(const PlanarScan& scan) { return {{{Pose2(), scan}}}; }

struct SearchedMap {
  explicit SearchedMap(Submap m) : map(std::move(m)), global(map) {}
  RelocalizationAnswer locate(const PlanarScan& scan) const {
    Relocalizer relocalizer(global, MatcherConfig(), RelocalizationConfig());
    return relocalizer.locate(queryOf(scan));
  }
  Submap map;
  GlobalMap global;
};

TEST(Relocalizer, FindsTheVehicleAtEveryYaw) {
  const SearchedMap scene(room::map());
  for (const Pose2& truth : {Pose2(1, -1, 2.1), Pose2(-2, 1.5, -2.8), Pose2(0.3, 0.2, 0.1)}) {
    const RelocalizationAnswer answer = scene.locate(room::scanFrom(truth));
    ASSERT_EQ(answer.state, RelocalizationState::kFound) << answer.reason;
    EXPECT_LT(truth.between(answer.pose().mean).distance(), 0.05);
    EXPECT_LT(std::abs(truth.between(answer.pose().mean).yaw), 0.02);
  }
}

TEST(Relocalizer, TwoEqualRoomsAreAmbiguous) {
  Submap map = room::map();
  insertAt(30.0, moved(room::walls(), 30.0), map);
  const SearchedMap scene(std::move(map));
  const Pose2 truth(1, -1, 2.1);
  const RelocalizationAnswer answer = scene.locate(room::scanFrom(truth));
  EXPECT_EQ(answer.state, RelocalizationState::kAmbiguous) << answer.reason;
  ASSERT_GE(answer.hypotheses.size(), 2U);
  EXPECT_NEAR(answer.hypotheses[0].match.pose.between(answer.hypotheses[1].match.pose).distance(),
              30.0, 0.1);
}

/// The rays that end left of x = 0.8 m in the room.
PlanarScan leftOf(PlanarScan scan, const Pose2& room_T_base) {
  const auto isRight = [&](const PlanarRay& ray) {
    return (room_T_base * ray.end.cast<double>()).x() > 0.8;
  };
  scan.rays.erase(std::remove_if(scan.rays.begin(), scan.rays.end(), isRight), scan.rays.end());
  return scan;
}

TEST(Relocalizer, AnotherBuildingIsRefused) {
  const SearchedMap scene(room::map());
  for (const Pose2& pose : {Pose2(0, 0.2, 0), Pose2(-3, 0.4, 1), Pose2(4.4, -0.4, 3)}) {
    const RelocalizationAnswer answer = scene.locate(room::scanFrom(pose, otherRoom()));
    EXPECT_NE(answer.state, RelocalizationState::kFound);
    EXPECT_STRNE(answer.reason, "");
  }
}

TEST(Relocalizer, AScanOfTenBeamsSaysNothing) {
  const SearchedMap scene(room::map());
  const RelocalizationAnswer answer = scene.locate(room::scanFrom({1, -1, 2}, room::walls(), 10));
  EXPECT_EQ(answer.state, RelocalizationState::kUnknown);
  EXPECT_STREQ(answer.reason, "too few hits");
}

TEST(Relocalizer, AnEmptyMapHasNoPlaces) {
  const SearchedMap scene{Submap(OccupancyGridConfig())};
  EXPECT_EQ(scene.locate(room::scanFrom({})).state, RelocalizationState::kUnknown);
}

TEST(Relocalizer, AnInterruptedSearchGivesTheSameAnswer) {
  const SearchedMap scene(room::map());
  const PlanarScan scan = room::scanFrom({1, -1, 2.1});
  const RelocalizationAnswer whole = scene.locate(scan);
  Relocalizer relocalizer(scene.global, MatcherConfig(), RelocalizationConfig());
  relocalizer.begin(queryOf(scan));
  int steps = 0;
  while (relocalizer.isSearching()) relocalizer.advance(1'000'000), ++steps;
  EXPECT_GT(steps, 3);
  EXPECT_EQ(relocalizer.answer().state, whole.state);
  ASSERT_EQ(relocalizer.answer().hypotheses.size(), whole.hypotheses.size());
  EXPECT_EQ(relocalizer.answer().pose().mean.x, whole.pose().mean.x);
}

/// The search leaves nothing out: no pose of a fine lattice scores better.
TEST(GlobalSearch, IsExact) {
  const Submap map = room::map();
  const GlobalMap global(map);
  const Points points = hitsOf(room::scanFrom({1, -1, 2.1}));
  GlobalSearch search(global, points, GlobalSearchConfig());
  WorkBudget budget(4'000'000'000);
  ASSERT_TRUE(search.run(budget));
  ASSERT_TRUE(search.isComplete());
  ASSERT_FALSE(search.hypotheses().empty());
  EXPECT_GT(search.hypotheses().front().score, 0.85);
}

/// A part of the room was never seen. That says nothing against the pose.
TEST(GlobalSearch, UnknownSpaceIsNoContradiction) {
  Submap map{OccupancyGridConfig()};
  for (const Pose2& pose : {Pose2(-1, 0.5, 0), Pose2(-2, 1, 1), Pose2(0, 0.4, 2)})
    map.insert(leftOf(room::scanFrom(pose), pose), pose);
  const GlobalMap global(map);
  const Pose2 truth(-0.5, 0.6, 0.3);
  GlobalSearch search(global, hitsOf(room::scanFrom(truth)), GlobalSearchConfig());
  WorkBudget budget(4'000'000'000);
  ASSERT_TRUE(search.run(budget));
  ASSERT_FALSE(search.hypotheses().empty());
  EXPECT_LT(truth.between(search.hypotheses().front().pose).distance(), 0.1);
  EXPECT_GT(search.hypotheses().front().score, 0.67) << "that share of the points is known";
}

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

TEST(PictureMap, AVehicleIsFoundInThePicture) {
  const Submap built = room::map();
  const SearchedMap scene(submapOf(built.grid().snapshot(), OccupancyGridConfig()));
  EXPECT_EQ(scene.map.grid().snapshot().width, built.grid().snapshot().width);
  const Pose2 truth(1, -1, 2.1);
  const RelocalizationAnswer answer = scene.locate(room::scanFrom(truth));
  ASSERT_EQ(answer.state, RelocalizationState::kFound) << answer.reason;
  EXPECT_LT(truth.between(answer.pose().mean).distance(), 0.05);
}

}  // namespace
}  // namespace kestrel
