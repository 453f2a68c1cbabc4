// SPDX-License-Identifier: BSD-3-Clause
// What was joined is taken back when later evidence speaks against it.
#include <gtest/gtest.h>

#include <algorithm>

#include "building.h"
#include "kestrel_slam/merging/map_merger.h"

namespace kestrel {
namespace {

using building::beginOf;
using building::mapOf;
using building::tour;
using building::Variant;

TEST(Undo, TwinsAreJoinedOnlyUntilTheyDiffer) {
  // Both vehicles see the same until they come into the room that differs.
  Variant twin;
  twin.other_room = true;
  const VehicleMap a = mapOf("a", {}, tour(0, 2)), b = mapOf("b", twin, tour(0, 2));
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(beginOf(a, 62));
  merger.update(beginOf(b, 62));
  ASSERT_EQ(merger.merge().pairs.front().state, PairState::kJoined);
  merger.update(a);
  merger.update(b);
  const MergeResult later = merger.merge();
  EXPECT_EQ(later.pairs.front().state, PairState::kContradicted) << later.pairs.front().reason;
  EXPECT_EQ(later.largestGroup(), 1U);
}

TEST(Undo, TheMapOfAllVehiclesTakesAPairBack) {
  // Two vehicles are joined as the user says, until a third one shows where they are.
  VehicleMap west = mapOf("west", {}, tour(0, 0)), east = mapOf("east", {}, tour(2, 2));
  west.world_T_map = Pose2();
  const Pose2 truth = tour(0, 0).front().between(tour(2, 2).front());
  east.world_T_map = Pose2(9.0, 0.0, 0.0) * truth;
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(west);
  merger.update(east);
  EXPECT_EQ(merger.merge().pairs.front().state, PairState::kGiven);
  merger.update(mapOf("both", {}, tour(0, 2)));
  const MergeResult later = merger.merge();
  EXPECT_EQ(later.pairs.front().state, PairState::kUndone) << later.pairs.front().reason;
  EXPECT_EQ(later.largestGroup(), 3U);
  EXPECT_LT(truth.between(later.poses[0].front().between(later.poses[1].front())).distance(), 0.2);
}

}  // namespace
}  // namespace kestrel
