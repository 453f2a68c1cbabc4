// SPDX-License-Identifier: BSD-3-Clause
// A vehicle whose laser looks away from where it flies.
#include <gtest/gtest.h>

#include <cmath>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

/// A corridor of 2 m × 30 m along x with a door in a niche every 2.5 m, at other places on the left
/// than on the right.
std::vector<room::Segment> corridorWithDoors() {
  constexpr double kWidth = 0.9, kDepth = 0.12, kEvery = 2.5, kLength = 30.0;
  std::vector<room::Segment> walls = {{kLength, -1.2, kLength, 1.2}, {0.0, -1.2, 0.0, 1.2}};
  for (const double side : {-1.0, 1.0}) {
    const double y = side, niche = side * (1.0 + kDepth);
    double x = 0.0;
    for (double door = side > 0.0 ? 0.7 : 1.6; door + kWidth < kLength; door += kEvery) {
      walls.push_back({x, y, door, y});
      walls.push_back({door, y, door, niche});
      walls.push_back({door, niche, door + kWidth, niche});
      walls.push_back({door + kWidth, niche, door + kWidth, y});
      x = door + kWidth;
    }
    walls.push_back({x, y, kLength, y});
  }
  return walls;
}

/// A scan of the 180° before the vehicle, with one beam per degree and an error of 1 cm.
PlanarScan scanAhead(const Pose2& pose, const std::vector<room::Segment>& walls, Random& random) {
  PlanarScan scan = room::scanFrom(pose, walls, 360, 20.0);
  std::vector<PlanarRay> ahead;
  for (PlanarRay& ray : scan.rays) {
    if (ray.end.x() < 0.0F) continue;
    ray.end *= 1.0F + 0.01F * static_cast<float>(random.gaussian()) / ray.end.norm();
    ahead.push_back(ray);
  }
  scan.rays = ahead;
  return scan;
}

/// The largest error along the corridor, m, from x = 20 m on, with 0.3 m/s and five scans a second.
double largestError(double speed) {
  const std::vector<room::Segment> walls = corridorWithDoors();
  Random random(1);
  const double start = speed < 0.0 ? 20.0 : 4.0;
  Mapper mapper{MapperConfig()};
  mapper.reset(Pose2(start, 0.0, 0.0));
  double largest = 0.0;
  for (int i = 0; i < 250; ++i) {
    const double time = 0.2 * i;
    const Pose2 truth(start + speed * time, 0.1 * std::sin(0.3 * time),
                      0.05 * std::sin(0.5 * time));
    PlanarScan scan = scanAhead(truth, walls, random);
    scan.stamp = scan.time = 100.0 + time;
    largest = std::max(largest, std::abs(mapper.process(scan).pose.x - truth.x));
  }
  return largest;
}

TEST(BackwardFlight, DoesNotStandStillInACorridor) {
  EXPECT_LT(largestError(-0.3), 0.1);
  EXPECT_LT(largestError(0.3), 0.1);
}

}  // namespace
}  // namespace kestrel
