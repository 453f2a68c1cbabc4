// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/flight_measurement.h"
#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

VehicleModel utmVehicle() {
  VehicleModel vehicle;
  vehicle.laser = laserModel("utm30lx");
  return vehicle;
}

/// Four turns on the spot at 2 rad/s, then four turns back.
FlightTrial spin() {
  constexpr double kRate = 2.0, kTurn = 8.0 * kPi;
  FlightTrial trial = flightIn("spin at 2 rad/s", "laboratory");
  FlightPlan& plan = trial.place.plan;
  const FlightPlan::Waypoint start = plan.waypoints.front();
  FlightPlan::Waypoint turned = start;
  turned.yaw += kTurn;
  plan.waypoints = {start, turned, start};
  plan.yaw_rate_rad_s = kRate;
  plan.nose_forward = false;
  return trial;
}

/// The laboratory loop with stops at every waypoint and tilt of up to 20 degrees between them.
FlightTrial agile(const std::string& name) {
  constexpr double kSpeed = 2.5, kAcceleration = 3.3;  // tan 20 deg is 3.6 m/s²
  FlightTrial trial = flightIn(name, "laboratory");
  FlightPlan& plan = trial.place.plan;
  plan.smooth = false;
  plan.speed_m_s = kSpeed;
  plan.acceleration_m_s2 = kAcceleration;
  return trial;
}

FlightTrial agileLevel() {
  FlightTrial trial = agile("path of the tilted flight, level");
  trial.place.quadrotor.level = true;
  return trial;
}

FlightTrial agileUnprojected() {
  FlightTrial trial = agile("tilted flight, projector off");
  trial.options.use_imu = false;
  return trial;
}

FlightTrial ring(double resolution_m) {
  FlightTrial trial =
      flightIn(resolution_m > 0.05 ? "corridor ring, 10 cm" : "corridor ring, 5 cm", "ring");
  trial.config.mapper.grid.resolution_m = resolution_m;
  return trial;
}

FlightTrial lidar() {
  FlightTrial trial = flightIn("laboratory loop, VLP-16", "laboratory");
  trial.vehicle.laser.reset();
  trial.vehicle.lidar = lidarModels().front();
  return trial;
}

FlightTrial rawImu() {
  FlightTrial trial = flightIn("laboratory loop, gyro and accelerometer only", "laboratory");
  trial.vehicle.imu->gives_orientation = false;
  return trial;
}

FlightTrial shortRange() {
  FlightTrial trial = flightIn("straight corridor, URG-04LX", "corridor");
  trial.vehicle.laser = laserModel("urg04lx");
  return trial;
}

FlightTrial laserOnly() {
  FlightTrial trial = flightIn("straight corridor, laser only", "corridor");
  trial.options.use_imu = false;
  return trial;
}

}  // namespace

FlightTrial flightIn(const std::string& name, const std::string& place_name) {
  FlightTrial trial;
  trial.name = name;
  trial.place = place(place_name);
  trial.vehicle = utmVehicle();
  return trial;
}

std::vector<FlightTrial> standardFlights() {
  constexpr double kCoarse = 0.1, kFine = 0.05;
  return {flightIn("laboratory loop, 5 cm", "laboratory"),
          rawImu(),
          lidar(),
          ring(kCoarse),
          ring(kFine),
          spin(),
          agile("tilt up to 20 deg"),
          agileLevel(),
          agileUnprojected(),
          flightIn("climb in the cluttered room", "cluttered"),
          flightIn("glass walls", "glass"),
          flightIn("doors", "doors"),
          flightIn("walking people", "people"),
          flightIn("hall larger than the laser range", "hall"),
          flightIn("straight corridor", "corridor"),
          shortRange(),
          laserOnly()};
}

}  // namespace kestrel
