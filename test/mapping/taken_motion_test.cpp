// SPDX-License-Identifier: BSD-3-Clause
// A vehicle that goes on in another map: what is known about its motion goes with it.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/mapping/mapper.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kPeriod = 0.2, kSpeed = 1.0, kFast = 2.0;
constexpr int kSteps = 5;

/// Both walls of a long corridor of 2 m.
std::vector<room::Segment> plainCorridor() {
  return {{-40.0, -1.0, 60.0, -1.0}, {-40.0, 1.0, 60.0, 1.0}};
}

PlanarScan scanAt(double x, double time, const std::vector<room::Segment>& walls) {
  static Random random(1);
  PlanarScan scan = room::scanFrom(Pose2(x, 0.0, 0.0), walls, 360, 10.0);
  for (PlanarRay& ray : scan.rays)
    ray.end *= 1.0F + 0.01F * static_cast<float>(random.gaussian()) / ray.end.norm();
  scan.stamp = scan.time = 100.0 + time;
  return scan;
}

/// A mapper in the room, whose vehicle has this speed.
Mapper flownInTheRoom(double speed) {
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 10; ++i)
    mapper.process(scanAt(-2.0 + speed * kPeriod * i, kPeriod * i, room::walls()));
  return mapper;
}

TEST(TakenMotion, GoesOnWhereTheScansShowNoSpeed) {
  const Mapper before = flownInTheRoom(kSpeed);
  Mapper mapper{MapperConfig()};
  for (int i = 0; i < 10; ++i) {
    const PlanarScan scan = scanAt(kSpeed * kPeriod * i, 2.0 + kPeriod * i, plainCorridor());
    if (i == 0) mapper.takeMotion(before, scan, std::nullopt);
    mapper.process(scan);
  }
  EXPECT_NEAR(mapper.pose().x, 9 * kPeriod * kSpeed, 0.4);
}

/// The scans show no motion: the claimed error must cover it.
void expectCovered(const MapperResult& result, double true_x) {
  EXPECT_LT(std::abs(result.pose.x - true_x), 3.0 * std::sqrt(result.covariance(0, 0)));
}

TEST(TakenMotion, AnOldSpeedIsUncertain) {
  const Mapper before = flownInTheRoom(0.0);
  Mapper mapper{MapperConfig()};
  MapperResult result;
  for (int i = 0; i <= kSteps; ++i) {
    const PlanarScan scan = scanAt(kFast * kPeriod * i, 4.0 + kPeriod * i, plainCorridor());
    if (i == 0) mapper.takeMotion(before, scan, std::nullopt);
    result = mapper.process(scan);
  }
  expectCovered(result, kSteps * kPeriod * kFast);
}

TEST(TakenMotion, AFoundVehicleHasTheSpeedErrorThatWasMeasured) {
  const Mapper before = flownInTheRoom(0.0);
  Submap map{OccupancyGridConfig()};
  for (int i = -20; i < 40; ++i)
    map.insert(scanAt(0.25 * i, 0.0, plainCorridor()), Pose2(0.25 * i, 0.0, 0.0));
  Mapper local{MapperConfig()}, found(MapperConfig(), std::move(map));
  const PlanarScan first = scanAt(0.0, 4.0, plainCorridor());
  local.takeMotion(before, first, std::nullopt);
  local.process(first);
  found.setFoundPose(Pose2(), local);
  MapperResult result;
  for (int i = 1; i <= kSteps; ++i)
    result = found.process(scanAt(kFast * kPeriod * i, 4.0 + kPeriod * i, plainCorridor()));
  expectCovered(result, kSteps * kPeriod * kFast);
}

}  // namespace
}  // namespace kestrel
