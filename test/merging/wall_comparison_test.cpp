// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/merging/wall_comparison.h"

#include <gtest/gtest.h>

#include <memory>

namespace kestrel {
namespace {

constexpr float kWallY = 0.05F;  // of a wall from x = 0 to 9 m
constexpr int kScans = 6;

using Rays = std::vector<PlanarRay>;

/// A vehicle that saw the same rays with each of some scans. Its frame is that of the wall.
VehicleMap mapOfRays(const std::string& name, const Rays& rays) {
  VehicleMap map;
  map.name = name;
  for (std::size_t i = 0; i < kScans; ++i) {
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->id = i;
    keyframe->scan = CompactScan(rays);
    map.keyframes.push_back({std::move(keyframe), 0, Pose2()});
    map.poses.emplace_back();
    if (i > 0)
      map.edges.push_back({i - 1, i, Pose2(), Eigen::Matrix3d::Identity(), EdgeKind::kOdometry});
  }
  map.places = {{0, 0, kScans}};
  return map;
}

/// From 2 m beside the wall.
VehicleMap besideWall() {
  Rays rays;
  for (float x = 0.0F; x < 9.0F; x += 0.05F) rays.push_back({{4.5F, 2.0F}, {x, kWallY}, true});
  return mapOfRays("beside", rays);
}

/// Beams along the wall, in the cells where it stands. None of them passes through it.
Rays raysAlongWall() {
  Rays rays;
  for (float x = 0.5F; x < 9.0F; x += 0.05F)
    rays.push_back({{x - 8.0F, 0.5F}, {x, kWallY - 0.03F}, false});
  return rays;
}

double differingWall(const VehicleMap& a, const VehicleMap& b) {
  const JointMap joint(MapperConfig(), {&a, &b});
  Loop loop;
  loop.anchor = 0;
  loop.query = kScans;
  return longestContradictingWall(joint, joint.graph().vertices, {loop}, 0, 1);
}

TEST(WallComparison, BeamsAlongAWallDoNotContradictIt) {
  EXPECT_LT(differingWall(besideWall(), mapOfRays("along", raysAlongWall())), 0.5);
}

TEST(WallComparison, BeamsThroughAWallContradictIt) {
  Rays rays = raysAlongWall();
  for (float x = 3.0F; x < 6.0F; x += 0.05F) rays.push_back({{x, 2.0F}, {x, -1.0F}, false});
  const double wall = differingWall(besideWall(), mapOfRays("through", rays));
  EXPECT_GT(wall, 2.9);
  EXPECT_LT(wall, 4.0);
}

}  // namespace
}  // namespace kestrel
