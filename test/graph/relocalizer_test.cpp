// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/relocalizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kestrel_slam/map/picture_map.h"
#include "rooms.h"

namespace kestrel {
namespace {

using rooms::insertAt;
using rooms::moved;
using rooms::otherRoom;

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
