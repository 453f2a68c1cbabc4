// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "building.h"
#include "kestrel_slam/merging/map_merger.h"

namespace kestrel {
namespace {

/// Four rooms of 6 m x 5 m with two doors each. Turned by 180 degrees, the building is the same but
/// for its doors, which are 1.2 m from where they were.
building::Walls fourRooms() {
  building::Walls all;
  loop_world::addBox(all, -6, -5, 12, 10);
  for (const double w : {-0.15, 0.15}) {
    const double doors[] = {-2.8, -1.4, 2.6, 4.0};
    all.insert(all.end(), {{-6, w, doors[0], w}, {doors[1], w, doors[2], w}, {doors[3], w, 6, w}});
    all.insert(all.end(), {{w, -5, w, doors[0]}, {w, doors[1], w, doors[2]}, {w, doors[3], w, 5}});
  }
  return all;
}

VehicleMap mapOf(const std::string& name, const std::vector<Eigen::Vector2d>& corners) {
  SubmapGraph graph{MapperConfig(), LoopConfig()};
  loop_world::Drive drive(fourRooms(), 0.0002);
  for (const Pose2& pose : building::along(corners)) drive.add(pose, graph);
  graph.finish();
  return vehicleMapOf(name, graph);
}

TEST(TwinRooms, TheMapOfOneRoomIsNotPutOntoAnotherRoom) {
  const std::vector<Eigen::Vector2d> north = {{-2.1, -1.8}, {-2.1, 1.5}, {-4.5, 1.5}, {-4.5, 3.8},
                                              {-1.2, 3.8},  {-1.2, 1.5}, {-4.5, 2.6}, {-1.5, 3.0}};
  const std::vector<Eigen::Vector2d> east = {{-1.8, -2.1}, {1.2, -2.1}, {4.5, -1.2}, {4.5, -3.8},
                                             {1.2, -3.8},  {1.2, -1.2}, {4.5, -2.6}, {1.5, -3.0}};
  MapMerger merger{MapperConfig(), LoopConfig()};
  merger.update(mapOf("north", north));
  merger.update(mapOf("east", east));
  const MergeResult result = merger.merge();
  const PairResult& pair = result.pairs.front();
  const Pose2 truth = building::along(north).front().between(building::along(east).front());
  const Pose2 found = result.poses[0].front().between(result.poses[1].front());
  EXPECT_TRUE(!pair.isJoined() || truth.between(found).distance() < 0.3)
      << toString(pair.state) << ": " << pair.reason << "; " << pair.first << " and " << pair.second
      << " matches, wall " << pair.differing_wall_m;
}

}  // namespace
}  // namespace kestrel
