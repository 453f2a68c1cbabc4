// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/simulated_recording.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "recording/read_all.h"
#include "simulation/test_flight.h"

namespace kestrel {
namespace {

constexpr std::uint64_t kSeed = 2;

Place smallPlace() {
  Place place;
  place.name = "room";
  place.parts = roomWithWalker();
  place.plan.waypoints = {{{0, 0, 1}, 0.2, 0.0}, {{1, 1, 1.2}, 1.0, 0.0}};
  return place;
}

TEST(SimulatedRecording, ContainsTheMessagesOfTheSensors) {
  const Place place = smallPlace();
  const VehicleModel vehicle = smallVehicle();
  SimulatedRecording recording(place, vehicle, kSeed);
  const World world(place.parts);
  const auto motion = flyQuadrotor(place.plan, place.quadrotor, kSeed);
  const auto events = simulateAll(world, *motion, vehicle, kSeed);

  const auto scans = messagesOf<LaserScan>(events);
  const auto read = readAll(recording);
  ASSERT_EQ(read.size(), scans.size());
  EXPECT_EQ(recording.scanCount(), scans.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].scan.stamp, scans[i].stamp);
    EXPECT_EQ(read[i].scan.ranges, scans[i].ranges);
    EXPECT_EQ(read[i].time, scans[i].stamp);
    EXPECT_FALSE(read[i].cloud || read[i].odom_T_base);
    EXPECT_EQ(read[i].base_T_laser.matrix(), vehicle.base_T_laser.matrix());
  }
  const auto imu = messagesOf<ImuSample>(events);
  ASSERT_EQ(recording.imu().samples.size(), imu.size());
  EXPECT_EQ(recording.imu().samples[50].stamp, imu[50].stamp);
  EXPECT_EQ(*recording.imu().samples[50].angular_velocity, *imu[50].angular_velocity);
  const auto heights = messagesOf<HeightSample>(events);
  ASSERT_EQ(recording.heights().size(), heights.size());
  EXPECT_EQ(recording.heights()[9].height_m, heights[9].height_m);
}

TEST(SimulatedRecording, TruthIsTheMotionAtTheStampsOfTheScans) {
  VehicleModel vehicle = smallVehicle();
  vehicle.stamp_jitter_s = 0.003;
  vehicle.loss_probability = 0.2;
  SimulatedRecording recording(smallPlace(), vehicle, kSeed);
  const Trajectory truth = recording.truth();
  ASSERT_EQ(recording.trueStates().size(), truth.size());
  const auto read = readAll(recording);
  ASSERT_EQ(read.size(), truth.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(truth[i].stamp, read[i].scan.stamp);
    const TrueState state = recording.motion().at(truth[i].stamp - kFlightStart);
    EXPECT_EQ(recording.trueStates()[i].world_T_base.matrix(), state.world_T_base.matrix());
    EXPECT_EQ(truth[i].pose.x, state.world_T_base.translation().x());
    EXPECT_EQ(truth[i].pose.y, state.world_T_base.translation().y());
    EXPECT_NEAR(truth[i].pose.yaw, yawOf(Eigen::Quaterniond(state.world_T_base.linear())), 1e-12);
    EXPECT_EQ(truth[i].pose, truePose(recording.motion(), truth[i].stamp));
  }
  EXPECT_NEAR(truth.front().pose.yaw, 0.2, 0.02);
  EXPECT_NEAR(truth.back().pose.x, 1.0, 0.02);
}

TEST(SimulatedRecording, TimesIncreaseEvenIfStampsJumpBack) {
  VehicleModel vehicle = smallVehicle();
  vehicle.stamp_jitter_s = 0.1;  // equal to the time between two scans
  SimulatedRecording recording(smallPlace(), vehicle, kSeed);
  const auto read = readAll(recording);
  std::size_t back = 0;
  for (std::size_t i = 1; i < read.size(); ++i) {
    EXPECT_GT(read[i].time, read[i - 1].time);
    back += read[i].scan.stamp < read[i - 1].scan.stamp ? 1U : 0U;
  }
  EXPECT_GT(back, 0U);
}

TEST(SimulatedRecording, WithoutALaserItContainsTheClouds) {
  VehicleModel vehicle = smallVehicle();
  vehicle.laser.reset();
  vehicle.base_T_lidar.translation().z() = 0.3;
  SimulatedRecording recording(smallPlace(), vehicle, kSeed);
  const auto read = readAll(recording);
  ASSERT_EQ(read.size(), recording.scanCount());
  ASSERT_GT(read.size(), 10U);
  for (const RecordedScan& scan : read) {
    ASSERT_TRUE(scan.cloud.has_value());
    EXPECT_EQ(scan.cloud->points.size(), 180U);
    EXPECT_TRUE(scan.scan.ranges.empty());
    EXPECT_EQ(scan.scan.stamp, scan.cloud->stamp);
    EXPECT_EQ(scan.base_T_laser.translation().z(), 0.3);
  }
}

TEST(SimulatedRecording, HasADescriptionAndRejectsAVehicleWithoutScanner) {
  EXPECT_EQ(SimulatedRecording(smallPlace(), smallVehicle(), 1).description(),
            "simulated flight in room with small");
  EXPECT_THROW(SimulatedRecording(smallPlace(), VehicleModel(), 1), std::invalid_argument);
}

}  // namespace
}  // namespace kestrel
