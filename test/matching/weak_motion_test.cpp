// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/weak_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "room.h"

namespace kestrel {
namespace {

constexpr double kObservable = 0.007;  // MatcherConfig::degenerate_share
constexpr double kReach = 0.5;         // m

std::vector<room::Segment> corridorUpTo(double x) {
  std::vector<room::Segment> walls = room::corridor();
  walls.push_back({x, -1.0, x, 1.0});
  return walls;
}

PlanarScan scanOf(const std::vector<room::Segment>& walls) {
  return room::scanFrom(Pose2(), walls, 1440, 20.0);
}

TEST(WeakMotion, TheEndOfACorridorShowsThePosition) {
  Submap map{OccupancyGridConfig()};
  const PlanarScan scan = scanOf(corridorUpTo(6.0));
  map.insert(scan, Pose2());
  const WeakMotion weak = weakMotion(map, hitsOf(scan), Pose2());
  EXPECT_NEAR(std::abs(weak.direction.x()), 1.0, 0.01);
  EXPECT_GT(weak.constraint, kObservable);
  const AlongFit fit = fitAlong(map, hitsOf(scan), Pose2(0.15, 0, 0), weak, kReach);
  const double sign = weak.direction.x() > 0.0 ? 1.0 : -1.0;
  EXPECT_NEAR(sign * fit.distance_m, -0.15, 0.03);
}

TEST(WeakMotion, AWallIsClearEvidenceAndAPoleIsNot) {
  constexpr double kClear = 2.0, kAwayM = 0.2;
  const auto evidence = [](const std::vector<room::Segment>& walls) {
    Submap map{OccupancyGridConfig()};
    const PlanarScan scan = room::scanFrom(Pose2(), walls, 360, 20.0);
    map.insert(scan, Pose2());
    const WeakMotion along{Eigen::Vector2d::UnitX(), 0.0, 0.0};
    return evidenceAgainst(map, hitsOf(scan), Pose2(), along, kAwayM);
  };
  EXPECT_GT(evidence(corridorUpTo(1.5)), kClear);
  std::vector<room::Segment> with_pole = room::corridor();
  with_pole.push_back({3.0, -0.1, 3.0, 0.1});
  EXPECT_LT(evidence(with_pole), kClear);
  EXPECT_NEAR(evidence(room::corridor()), 0.0, 0.1);
}

TEST(WeakMotion, ALineThatAppearsInFreeSpaceDoesNot) {
  // A tilted laser sees the floor as a line across the corridor, which moves with the vehicle.
  Submap map{OccupancyGridConfig()};
  map.insert(scanOf(room::corridor()), Pose2());
  const PlanarScan floor = scanOf(corridorUpTo(6.0));
  map.insert(floor, Pose2());
  map.insert(floor, Pose2());
  ASSERT_TRUE(map.grid().isOccupied(map.grid().cellAt({6.01F, 0.0F})));
  const WeakMotion weak = weakMotion(map, hitsOf(floor), Pose2());
  EXPECT_LT(weak.constraint, kObservable);
  const AlongFit fit = fitAlong(map, hitsOf(floor), Pose2(0.15, 0, 0), weak, kReach);
  EXPECT_TRUE(std::isinf(fit.variance_m2));
}

TEST(WeakMotion, TheEndOfTheFieldOfViewDoesNot) {
  // The walls behind the vehicle are unknown, which does not mean that there are none.
  Submap map{OccupancyGridConfig()};
  PlanarScan scan = scanOf(room::corridor());
  for (PlanarRay& ray : scan.rays) {
    const double angle = std::atan2(ray.end.y(), ray.end.x());
    if (std::abs(angle) > 2.2) ray = {Eigen::Vector2f::Zero(), Eigen::Vector2f::Zero(), false};
  }
  map.insert(scan, Pose2());
  const WeakMotion weak = weakMotion(map, hitsOf(scan), Pose2());
  EXPECT_LT(weak.constraint, kObservable);
  const AlongFit fit = fitAlong(map, hitsOf(scan), Pose2(-0.1, 0, 0), weak, kReach);
  EXPECT_TRUE(std::isinf(fit.variance_m2));
}

}  // namespace
}  // namespace kestrel
