// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/height_measurement.h"

#include <gtest/gtest.h>

#include "kestrel_slam/experiments/merging_measurement.h"
#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

VehicleMap climb(VehicleModel vehicle, std::vector<double>& heights) {
  Place rooms = place("doors");
  rooms.plan.waypoints.resize(1);
  FlightPlan::Waypoint up = rooms.plan.waypoints.front();
  up.position += Eigen::Vector3d(0.4, 0.4, 1.2);
  rooms.plan.waypoints.push_back(up);
  vehicle.laser->rate_hz = 10.0;
  SimulatedRecording recording(rooms, vehicle, 1);
  const VehicleMap map = mapVehicle("uav", recording, {}, {}).map;
  for (const LocalKeyframe& keyframe : map.keyframes) {
    const double stamp = keyframe.keyframe->stamp - kFlightStart;
    const Eigen::Isometry3d base = recording.motion().at(stamp).world_T_base;
    heights.push_back((base * vehicle.base_T_laser).translation().z());
  }
  return map;
}

TEST(HeightsOfKeyframes, AreThoseOfTheLaserWhereARangeFinderMeasuresThem) {
  std::vector<double> heights;
  const VehicleMap map = climb(quadrotorWith("utm30lx"), heights);
  ASSERT_GE(map.keyframes.size(), 5U);
  std::size_t known = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const ScanHeight& height = map.keyframes[i].keyframe->height;
    if (!height.isKnown()) continue;
    ++known;
    EXPECT_NEAR(height.base_m, heights[i], 0.06) << i;
  }
  EXPECT_GE(known + 1, heights.size());
  EXPECT_GT(heights.back() - heights.front(), 1.0);
}

TEST(HeightsOfKeyframes, AreUnknownWhereNothingMeasuresThem) {
  VehicleModel vehicle = quadrotorWith("utm30lx");
  vehicle.range_finder.reset();
  vehicle.imu.reset();
  std::vector<double> heights;
  for (const LocalKeyframe& keyframe : climb(vehicle, heights).keyframes)
    EXPECT_FALSE(keyframe.keyframe->height.isKnown());
}

}  // namespace
}  // namespace kestrel
