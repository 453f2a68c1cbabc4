// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/map_merger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "building.h"

namespace kestrel {
namespace {

using building::beginOf;
using building::mapOf;
using building::tour;
using building::Variant;

MergeResult merged(const std::vector<VehicleMap>& maps) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  for (const VehicleMap& map : maps) merger.update(map);
  return merger.merge();
}

const VehicleMap& first() {
  static const VehicleMap map = mapOf("a", {}, tour(0, 2));
  return map;
}

const VehicleMap& second() {
  static const VehicleMap map = mapOf("b", {}, tour(2, 0));
  return map;
}

std::string describe(const PairResult& pair) {
  return std::string(toString(pair.state)) + ": " + pair.reason + "; " +
         std::to_string(pair.found) + " found, " + std::to_string(pair.contradicting) + " of " +
         std::to_string(pair.compared) + " contradict, along " +
         std::to_string(pair.longest_contradiction_m);
}

TEST(MapMerger, TwoVehiclesInOneBuildingAreJoined) {
  const MergeResult result = merged({first(), second()});
  const PairResult& pair = result.pairs.front();
  ASSERT_EQ(pair.state, PairState::kJoined) << describe(pair);
  EXPECT_GT(pair.confidence, 0.5);
  // Where the second vehicle began, in the frame of the first pose of the first one.
  const Pose2 truth = tour(0, 2).front().between(tour(2, 0).front());
  const Pose2 found = result.poses[0].front().between(result.poses[1].front());
  EXPECT_LT(truth.between(found).distance(), 0.1);
  EXPECT_EQ(result.largestGroup(), 2U);
  EXPECT_GT(result.loops_between, 10U);
  EXPECT_LT(pair.differing_wall_m, 0.5);
}

TEST(MapMerger, TheSameInputGivesTheSamePoses) {
  EXPECT_EQ(merged({first(), second()}).poses, merged({first(), second()}).poses);
}

TEST(MapMerger, MovedFurnitureDoesNotHinder) {
  Variant moved;
  moved.furniture_m = 1.5;
  const MergeResult result = merged({first(), mapOf("b", moved, tour(2, 0))});
  EXPECT_EQ(result.pairs.front().state, PairState::kJoined) << describe(result.pairs.front());
}

TEST(MapMerger, FurnitureThatOnlyOneVehicleSeesDoesNotHinder) {
  Variant lower;
  lower.low_cabinet = true;
  const MergeResult result = merged({first(), mapOf("b", lower, tour(2, 0))});
  EXPECT_EQ(result.pairs.front().state, PairState::kJoined) << describe(result.pairs.front());
  EXPECT_LT(result.pairs.front().differing_wall_m, 0.8);
}

TEST(MapMerger, TwinBuildingsThatDifferInOneRoomAreNotMerged) {
  Variant twin;
  twin.other_room = true;
  const MergeResult result = merged({first(), mapOf("b", twin, tour(2, 0))});
  EXPECT_EQ(result.pairs.front().state, PairState::kContradicted) << describe(result.pairs.front());
  EXPECT_EQ(result.largestGroup(), 1U);
}

TEST(MapMerger, TwinBuildingsThatDifferInOneWallAreNotMerged) {
  Variant deeper, divided, beside;
  deeper.deeper_m = 1.2;
  divided.partition_x = 10.3;
  beside.partition_x = 8.6;  // so near to a wall that it could be a cabinet, but too long for one
  for (const Variant& twin : {deeper, divided, beside}) {
    const MergeResult result = merged({first(), mapOf("b", twin, tour(2, 0))});
    const PairResult& pair = result.pairs.front();
    EXPECT_EQ(pair.state, PairState::kContradicted) << describe(pair);
    EXPECT_GT(pair.differing_wall_m, 1.2);
  }
}

TEST(MapMerger, ATwinWhoseWallIsBesideFurnitureIsNotMerged) {
  // The furniture explains what stands in front of it, but not the wall beyond its ends.
  Variant divided;
  divided.partition_x = 13.3;
  const MergeResult result = merged({first(), mapOf("b", divided, tour(2, 0))});
  const PairResult& pair = result.pairs.front();
  EXPECT_EQ(pair.state, PairState::kContradicted)
      << describe(pair) << ", wall " << pair.differing_wall_m;
}

TEST(MapMerger, AnotherBuildingIsNotMerged) {
  Variant other;
  other.other_place = true;
  const MergeResult result = merged({first(), mapOf("b", other, tour(2, 0))});
  EXPECT_FALSE(result.pairs.front().isJoined()) << describe(result.pairs.front());
}

TEST(MapMerger, AMirroredMapIsNotMerged) {
  Variant mirrored;
  mirrored.mirrored = true;
  const MergeResult result = merged({first(), mapOf("b", mirrored, tour(2, 0, true))});
  EXPECT_FALSE(result.pairs.front().isJoined()) << describe(result.pairs.front());
}

TEST(MapMerger, ATinyMapCannotBeUsed) {
  const MergeResult result = merged({first(), mapOf("b", {}, {Pose2(4, 0, 0), Pose2(4.3, 0, 0)})});
  EXPECT_EQ(result.pairs.front().state, PairState::kUnusable);
  EXPECT_NE(result.pairs.front().reason.find("b"), std::string::npos);
  EXPECT_EQ(merged({first(), VehicleMap{"empty", {}, {}, {}, {}, {}}}).pairs.front().state,
            PairState::kUnusable);
}

TEST(MapMerger, AMapOfOneSquareMeterIsNotMerged) {
  std::vector<Pose2> spot;
  for (int i = 0; i < 60; ++i)
    spot.emplace_back(4.0 + 0.4 * std::sin(i), 0.4 * std::cos(i), 0.3 * i);
  const MergeResult result = merged({first(), mapOf("b", {}, spot)});
  EXPECT_FALSE(result.pairs.front().isJoined()) << describe(result.pairs.front());
}

TEST(MapMerger, VehiclesInOneRoomAreJoined) {
  // The way is shorter than two places need.
  const VehicleMap a = mapOf("a", {}, building::along({{4, 3.8}, {4, -3.5}, {4, 2}}));
  const MergeResult result = merged({a, mapOf("b", {}, building::along({{4, -3}, {4, 3.5}}))});
  EXPECT_EQ(result.pairs.front().state, PairState::kJoined) << describe(result.pairs.front());
}

TEST(MapMerger, ARestartedVehicleIsJoinedInTheSameRoom) {
  // It begins in the middle of the room, and never flies farther than 3 m from there.
  const VehicleMap before =
      mapOf("a", {}, building::along({{4, 2.4}, {2, 2.4}, {2, 3.6}, {6, 3.6}, {6, 2.4}, {3, 2.4}}));
  const VehicleMap after =
      mapOf("b", {}, building::along({{4, 3}, {2, 3.4}, {6, 3.4}, {5, 2.6}, {2, 2.2}, {4, 3}}));
  const MergeResult result = merged({before, after});
  EXPECT_EQ(result.pairs.front().state, PairState::kJoined) << describe(result.pairs.front());
}

TEST(MapMerger, LasersMayDiffer) {
  // One sees 12 m far with a beam every 2 degrees, the other one half of both.
  const VehicleMap coarse = mapOf("b", {}, tour(2, 0), {90, 6.0});
  for (const bool first_is_coarse : {false, true}) {
    const MergeResult result =
        first_is_coarse ? merged({coarse, first()}) : merged({first(), coarse});
    const PairResult& pair = result.pairs.front();
    ASSERT_EQ(pair.state, PairState::kJoined) << describe(pair);
    const std::size_t a = first_is_coarse ? 1 : 0;
    const Pose2 truth = tour(0, 2).front().between(tour(2, 0).front());
    const Pose2 found = result.poses[a].front().between(result.poses[1 - a].front());
    EXPECT_LT(truth.between(found).distance(), 0.1);
  }
}

TEST(MapMerger, ABentMapDoesNotBendTheOthers) {
  // A vehicle that lies about its way: its poses and motions turn where it did not.
  VehicleMap bent = mapOf("x", {}, tour(1, 0));
  for (std::size_t i = 0; i < bent.poses.size(); ++i) {
    bent.poses[i] = Pose2(0.0, 0.0, 0.01 * static_cast<double>(i)) * bent.poses[i];
    bent.keyframes[i].local_T_base = bent.poses[i];
  }
  for (PoseEdge& edge : bent.edges)
    edge.measured = bent.poses[edge.from].between(bent.poses[edge.to]);
  const MergeResult result = merged({first(), bent, second()});
  EXPECT_EQ(result.group[0], result.group[2]);
  const Pose2 truth = tour(0, 2).front().between(tour(2, 0).front());
  const Pose2 found = result.poses[0].front().between(result.poses[2].front());
  EXPECT_LT(truth.between(found).distance(), 0.1);
  EXPECT_NE(result.group[0], result.group[1]) << describe(result.pairs.front());
}

TEST(MapMerger, ClocksMayDifferByHours) {
  VehicleMap late = second();
  for (LocalKeyframe& keyframe : late.keyframes) {
    auto later = std::make_shared<Keyframe>(*keyframe.keyframe);
    later->stamp += 5.0 * 3600.0;
    later->time += 5.0 * 3600.0;
    keyframe.keyframe = later;
  }
  EXPECT_EQ(merged({first(), late}).poses, merged({first(), second()}).poses);
  EXPECT_EQ(merged({late, first()}).pairs.front().state, PairState::kJoined);
}

TEST(MapMerger, AWrongPoseThatWasGivenDoesNoHarm) {
  VehicleMap a = first(), b = second();
  a.world_T_map = Pose2();
  b.world_T_map = Pose2(3.0, -9.0, 2.0);
  const MergeResult result = merged({a, b});
  ASSERT_EQ(result.pairs.front().state, PairState::kJoined) << describe(result.pairs.front());
  const Pose2 truth = tour(0, 2).front().between(tour(2, 0).front());
  EXPECT_LT(truth.between(result.poses[0].front().between(result.poses[1].front())).distance(),
            0.1);
  // Where nothing is in common, the maps themselves say that the pose is wrong.
  VehicleMap west = mapOf("a", {}, tour(0, 0)), east = mapOf("b", {}, tour(2, 2));
  west.world_T_map = Pose2();
  east.world_T_map = Pose2(0.3, 0.2, 0.0);
  EXPECT_FALSE(merged({west, east}).pairs.front().isJoined());
}

TEST(MapMerger, ThreeVehiclesAndOneThatIsElsewhere) {
  Variant other;
  other.other_place = true;
  const MergeResult result =
      merged({mapOf("a", {}, tour(0, 1)), mapOf("x", other, tour(0, 1)), second()});
  EXPECT_EQ(result.group[0], result.group[2]);
  EXPECT_NE(result.group[0], result.group[1]);
}

TEST(MapMerger, AGrowingMapIsSearchedOnlyWhereItIsNew) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(first());
  merger.update(beginOf(second(), 60));
  merger.merge();
  const std::size_t before = merger.memory().searches();
  merger.merge();
  EXPECT_EQ(merger.memory().searches(), before) << "nothing is new";
  merger.update(second());
  const MergeResult grown = merger.merge();
  EXPECT_EQ(grown.pairs.front().state, PairState::kJoined) << describe(grown.pairs.front());
  MapMerger fresh{MapperConfig(), LoopConfig()};
  fresh.update(first());
  fresh.update(second());
  EXPECT_EQ(fresh.merge().poses, grown.poses) << "the result depends only on the maps";
  EXPECT_LT(merger.memory().searches() - before, fresh.memory().searches());
}

TEST(MapMerger, AMapThatItsGraphHasMovedIsNotSearchedAgain) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(first());
  merger.update(second());
  merger.merge();
  const std::size_t before = merger.memory().searches();
  VehicleMap moved = second();
  for (std::size_t i = 0; i < moved.poses.size(); ++i)
    moved.poses[i] = moved.poses[i] * Pose2(1e-4 * std::sin(0.1 * static_cast<double>(i)), 0, 0);
  merger.update(moved);
  EXPECT_EQ(merger.merge().pairs.front().state, PairState::kJoined);
  EXPECT_LT(merger.memory().searches() - before, before / 20);
}

TEST(MapMerger, AVehicleThatBeginsAnotherMapIsANewOne) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(first());
  merger.update(second());
  merger.merge();
  const VehicleMap restarted = mapOf("b", {}, tour(1, 0));
  merger.update(restarted);
  EXPECT_EQ(merger.merge().poses, merged({first(), restarted}).poses);
}

TEST(MapMerger, SeparatedVehiclesStaySeparated) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(first());
  merger.update(second());
  merger.separate(0, 1);
  EXPECT_EQ(merger.merge().pairs.front().state, PairState::kSeparated);
}

TEST(MapMerger, AGivenStartIsUsedWhereNothingIsInCommon) {
  VehicleMap a = mapOf("a", {}, tour(0, 0)), b = mapOf("b", {}, tour(2, 2));
  a.world_T_map = Pose2();
  b.world_T_map = tour(0, 0).front().between(tour(2, 2).front());
  const MergeResult result = merged({a, b});
  ASSERT_TRUE(result.pairs.front().isJoined()) << describe(result.pairs.front());
  EXPECT_LT(b.world_T_map->between(result.poses[1].front()).distance(), 0.3);
}

}  // namespace
}  // namespace kestrel
