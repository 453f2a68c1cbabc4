// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "building.h"
#include "kestrel_slam/merging/map_merger.h"

namespace kestrel {
namespace {

/// A room with furniture beside another one, with an opening of 1.6 m between them.
building::Walls rooms(bool closed) {
  using loop_world::addBox;
  building::Walls all;
  addBox(all, 0, 0, 7, 6);
  addBox(all, 7.2, 0, 5, 6);
  // Left and right of the opening; the faces between the rooms were drawn with the boxes.
  all.erase(all.begin() + 1);  // x = 7
  all.erase(all.begin() + 6);  // x = 7.2
  for (const double x : {7.0, 7.2}) {
    all.insert(all.end(), {{x, 0, x, 2.4}, {x, 4.0, x, 6}});
    if (closed) all.push_back({x, 2.4, x, 4.0});
  }
  for (const double y : {2.4, 4.0}) all.push_back({7.0, y, 7.2, y});
  addBox(all, 0.3, 0, 1.1, 0.5);
  addBox(all, 3.2, 5.4, 1.7, 0.6);
  addBox(all, 0, 3.1, 0.4, 1.3);
  addBox(all, 5.3, 0, 0.6, 0.9);
  addBox(all, 9.6, 5.2, 1.4, 0.8);
  return all;
}

/// A part of a flight: where, at which height, and whether it is above the opening.
struct Leg {
  std::vector<Eigen::Vector2d> corners;
  float height_m;
  bool above;
};

VehicleMap fly(const std::string& name, const std::vector<Leg>& legs, bool door = true) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  loop_world::Drive drive(rooms(!door), 0.0002);
  for (const Leg& leg : legs) {
    drive.see(rooms(leg.above || !door), leg.height_m);
    for (const Pose2& pose : building::along(leg.corners)) drive.add(pose, graph);
  }
  graph.finish();
  return vehicleMapOf(name, graph);
}

const std::vector<Eigen::Vector2d> kRound = {
    {1.5, 1.5}, {5.5, 1.5}, {5.5, 4.5}, {1.5, 4.5}, {1.5, 2}};
const std::vector<Eigen::Vector2d> kBack = {{1.5, 2}, {5.0, 2}, {5.0, 4}, {2, 4}, {2, 1.8}};

VehicleMap low(bool door = true) {
  return fly("low", {{kRound, 0.9F, false}, {kBack, 1.3F, false}}, door);
}
/// It first sees the opening, and then the wall above it.
VehicleMap both(bool door = true) {
  return fly(
      "both",
      {{kBack, 0.9F, false}, {kBack, 1.6F, false}, {kRound, 2.3F, true}, {kBack, 2.3F, true}},
      door);
}
VehicleMap high(bool door = true) {
  return fly("high", {{kBack, 2.2F, true}, {kRound, 2.3F, true}}, door);
}

VehicleMap withoutHeights(VehicleMap map) {
  for (LocalKeyframe& entry : map.keyframes) {
    auto keyframe = std::make_shared<Keyframe>(*entry.keyframe);
    keyframe->height = ScanHeight();
    entry.keyframe = keyframe;
  }
  return map;
}

PairResult merged(const VehicleMap& a, const VehicleMap& b) {
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(a);
  merger.update(b);
  return merger.merge().pairs.front();
}

std::string reasonAndWall(const PairResult& pair) {
  return std::string(toString(pair.state)) + ": " + pair.reason + ", wall " +
         std::to_string(pair.differing_wall_m);
}

TEST(Lintel, AVehicleThatSawTheOpeningAndTheWallAboveItIsJoined) {
  for (const auto& [a, b] : {std::pair(low(), both()), std::pair(both(), low())}) {
    const PairResult pair = merged(a, b);
    EXPECT_TRUE(pair.isJoined()) << reasonAndWall(pair);
    const PairResult unknown = merged(withoutHeights(a), withoutHeights(b));
    EXPECT_EQ(unknown.state, PairState::kContradicted) << reasonAndWall(unknown);
  }
}

TEST(Lintel, AnOpeningThatOnlyOneVehicleSawIsAContradiction) {
  EXPECT_EQ(merged(low(), high()).state, PairState::kContradicted);
}

TEST(Lintel, ATwinWithoutTheOpeningIsNotJoinedAtAnyHeight) {
  constexpr bool kNoDoor = false;
  std::vector<std::pair<VehicleMap, VehicleMap>> pairs = {{low(), low(kNoDoor)},
                                                          {low(), both(kNoDoor)},
                                                          {low(), high(kNoDoor)},
                                                          {both(), low(kNoDoor)},
                                                          {both(), both(kNoDoor)}};
  for (auto& [map, twin] : pairs) {
    twin.name += " in the twin";
    for (const PairResult& pair : {merged(map, twin), merged(twin, map)}) {
      EXPECT_EQ(pair.state, PairState::kContradicted)
          << map.name << ", " << twin.name << ": " << reasonAndWall(pair);
    }
  }
}

}  // namespace
}  // namespace kestrel
