// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <variant>
#include <vector>

#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// A motion in closed form: x = 2 sin t, y = 0, z = 1 + 0.1 sin t, with a constant yaw rate of 0.5
/// rad/s.
class KnownMotion : public Motion {
 public:
  explicit KnownMotion(double duration) : duration_(duration) {}
  double duration() const override { return duration_; }
  TrueState at(double t) const override {
    constexpr double kX = 2.0, kZ = 0.1, kTurn = 0.5;
    TrueState state;
    state.world_T_base = Eigen::Translation3d(kX * std::sin(t), 0.0, 1.0 + kZ * std::sin(t)) *
                         Eigen::AngleAxisd(kTurn * t, Eigen::Vector3d::UnitZ());
    state.velocity = {kX * std::cos(t), 0.0, kZ * std::cos(t)};
    state.acceleration = {-kX * std::sin(t), 0.0, -kZ * std::sin(t)};
    state.angular_velocity = {0.0, 0.0, kTurn};
    return state;
  }

 private:
  double duration_;
};

/// At rest at a height of 1 m.
class NoMotion : public Motion {
 public:
  explicit NoMotion(double duration) : duration_(duration) {}
  double duration() const override { return duration_; }
  TrueState at(double) const override {
    TrueState state;
    state.world_T_base.translation().z() = 1.0;
    return state;
  }

 private:
  double duration_;
};

inline World::Parts roomWithWalker() {
  World::Parts parts;
  parts.boxes = {{{4.0, 0.0, 1.5}, {0.2, 8.0, 3.0}},
                 {{-4.0, 0.0, 1.5}, {0.2, 8.0, 3.0}},
                 {{0.0, 4.0, 1.5}, {8.0, 0.2, 3.0}},
                 {{0.0, -4.0, 1.5}, {8.0, 0.2, 3.0}}};
  Walker walker;
  walker.corners = {{-3.0, -3.0}, {3.0, -3.0}};
  parts.walkers = {walker};
  return parts;
}

/// A small laser with noise.
inline LaserModel smallLaser() {
  LaserModel laser;
  laser.name = "small";
  laser.beams = 91;
  laser.angle_min = -1.5;
  laser.angle_increment = 3.0 / 90.0;
  laser.time_increment = 1e-4;
  laser.rate_hz = 10.0;
  laser.range_min = 0.1;
  laser.range_max = 30.0;
  laser.errors.sigma_m = 0.01;
  return laser;
}

inline LidarModel smallLidar() {
  LidarModel lidar;
  lidar.name = "small_lidar";
  lidar.elevations = {-0.2, 0.0, 0.2};
  lidar.columns = 60;
  lidar.rate_hz = 5.0;
  lidar.range_min = 0.5;
  lidar.range_max = 50.0;
  return lidar;
}

/// An IMU without any error.
inline ImuModel idealImu() {
  ImuModel imu;
  imu.gyro_noise = imu.gyro_bias = imu.gyro_bias_walk = 0.0;
  imu.accelerometer_noise = imu.accelerometer_bias = imu.accelerometer_bias_walk = 0.0;
  imu.misalignment_rad = imu.attitude_sigma_rad = imu.yaw_sigma_rad = 0.0;
  return imu;
}

inline VehicleModel smallVehicle() {
  VehicleModel vehicle;
  vehicle.laser = smallLaser();
  vehicle.lidar = smallLidar();
  return vehicle;
}

inline VehicleModel onlyImu(const ImuModel& imu) {
  VehicleModel vehicle;
  vehicle.imu = imu;
  vehicle.range_finder.reset();
  vehicle.barometer.reset();
  vehicle.truth_rate_hz = 0.0;
  return vehicle;
}

inline std::vector<FlightEvent> simulateAll(const World& world, const Motion& motion,
                                            const VehicleModel& vehicle, std::uint64_t seed) {
  FlightSimulator simulator(world, motion, vehicle, seed);
  std::vector<FlightEvent> events;
  FlightEvent event;
  while (simulator.next(event)) events.push_back(event);
  return events;
}

/// The messages of one type.
template <typename Message>
std::vector<Message> messagesOf(const std::vector<FlightEvent>& events) {
  std::vector<Message> messages;
  for (const FlightEvent& event : events) {
    if (const auto* message = std::get_if<Message>(&event.message)) messages.push_back(*message);
  }
  return messages;
}

}  // namespace kestrel
