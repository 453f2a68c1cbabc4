// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <utility>

#include "kestrel_slam/experiments/hard_flight.h"
#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

using Waypoint = FlightPlan::Waypoint;

/// A flight with a laser at 40 Hz and an IMU.
HardFlight hardFlightIn(const std::string& name, const std::string& place_name) {
  HardFlight flight;
  flight.trial = flightIn(name, place_name);
  return flight;
}

/// A flight of a level vehicle with a laser at `rate_hz` and no other sensor.
HardFlight laserOnly(const std::string& name, const std::string& place_name, double rate_hz) {
  HardFlight flight = hardFlightIn(name, place_name);
  flight.trial.place.quadrotor.level = true;
  flight.trial.vehicle.laser->rate_hz = rate_hz;
  flight.trial.vehicle.imu.reset();
  flight.trial.vehicle.range_finder.reset();
  return flight;
}

/// Twelve people who walk around the vehicle.
HardFlight crowd() {
  HardFlight flight = laserOnly("twelve people", "people", 40.0);
  std::vector<Walker>& walkers = flight.trial.place.parts.walkers;
  const std::vector<Walker> first = walkers;
  for (const double ahead : {2.0, 5.0}) {
    for (Walker walker : first) {
      walker.phase_m += ahead;
      walker.speed_m_s *= 0.9;
      walkers.push_back(walker);
    }
  }
  return flight;
}

/// Two rounds; half of the furniture is moved before the second round.
HardFlight movedFurniture() {
  constexpr double kMovedAt = 33.0;       // s, the end of the first round
  const Eigen::Vector2d kMove(0.0, 1.3);  // m, so that the old positions become visible
  HardFlight flight = laserOnly("furniture moved between two rounds", "people", 40.0);
  flight.limits.double_cells = 8;  // edges of boxes that moved
  Place& place = flight.trial.place;
  place.parts.walkers.clear();
  for (const double x : {-5.5, 5.2}) {
    for (const double y : {-2.2, 0.4, 2.6}) {
      Box box;
      box.center = {x, y, 0.8};
      box.size = {0.8, 0.5, 1.6};
      box.yaw = x * y;
      box.until_s = kMovedAt;
      place.parts.boxes.push_back(box);
      box.center.head<2>() += kMove;
      box.yaw += 1.0;
      std::swap(box.from_s, box.until_s);
      box.until_s = std::numeric_limits<double>::infinity();
      place.parts.boxes.push_back(box);
    }
  }
  const std::vector<Waypoint> round = place.plan.waypoints;
  place.plan.waypoints.insert(place.plan.waypoints.end(), round.begin() + 1, round.end());
  return flight;
}

HardFlight dropouts() {
  HardFlight flight = laserOnly("40 % of the beams drop out", "laboratory", 40.0);
  flight.trial.vehicle.laser->errors.dropout_probability = 0.4;
  return flight;
}

/// Three times, an obstacle close to the laser blocks half of the beams for one second.
HardFlight halfBlocked() {
  HardFlight flight = laserOnly("half of the view blocked for 1 s", "laboratory", 40.0);
  for (const double from : {10.0, 25.0, 40.0}) {
    BlockedView view;
    view.from_s = from;
    view.until_s = from + 1.0;
    view.first_rad = 0.0;
    flight.trial.vehicle.blocked_views.push_back(view);
  }
  return flight;
}

/// Blocks the whole view while the vehicle flies around a corner at 1 m/s.
void blockAll(HardFlight& flight, double range_m) {
  constexpr double kFrom = 12.0, kUntil = 14.0;  // s
  flight.trial.place.plan.speed_m_s = 1.0;
  BlockedView view;
  view.from_s = flight.blind_from_s = kFrom;
  view.until_s = flight.blind_until_s = kUntil;
  view.range_m = range_m;
  flight.lost_expected = range_m >= flight.trial.config.projector.beams.min_range_m;
  flight.trial.vehicle.blocked_views = {view};
}

HardFlight allBlocked() {
  HardFlight flight = laserOnly("all of the view blocked for 2 s", "laboratory", 40.0);
  blockAll(flight, BlockedView().range_m);
  return flight;
}

HardFlight allBlockedWithImu() {
  HardFlight flight = hardFlightIn("all of the view blocked for 2 s, with IMU", "laboratory");
  blockAll(flight, BlockedView().range_m);
  return flight;
}

/// The obstacle is closer than the minimum range. All scans are dropped, so the mapper gets none.
HardFlight noScans() {
  HardFlight flight = laserOnly("no scans for 2 s", "laboratory", 40.0);
  blockAll(flight, 0.5 * flight.trial.config.projector.beams.min_range_m);
  return flight;
}

HardFlight noReturns() {
  HardFlight flight = laserOnly("no returns for 2 s", "laboratory", 40.0);
  blockAll(flight, std::numeric_limits<double>::infinity());
  return flight;
}

/// Two turns on the spot at 2 rad/s, then two turns back.
HardFlight spin(double rate_hz) {
  HardFlight flight =
      laserOnly("rotation at 2 rad/s, " + std::to_string(static_cast<int>(rate_hz)) + " Hz, no IMU",
                "laboratory", rate_hz);
  FlightPlan& plan = flight.trial.place.plan;
  const Waypoint start = plan.waypoints.front();
  Waypoint turned = start;
  turned.yaw += 4.0 * kPi;
  plan.waypoints = {start, turned, start};
  plan.yaw_rate_rad_s = 2.0;
  plan.nose_forward = false;
  // The vehicle turns by 2° during a sweep of 19 ms. Without a gyro this distortion cannot be
  // corrected, so corners become thick.
  flight.limits.double_cells = 80;
  return flight;
}

/// Accelerates from rest to 3 m/s with 3 m/s², then brakes to rest.
HardFlight fastAcceleration(double rate_hz) {
  HardFlight flight = laserOnly(
      "acceleration of 3 m/s², " + std::to_string(static_cast<int>(rate_hz)) + " Hz, no IMU",
      "people", rate_hz);
  Place& place = flight.trial.place;
  place.parts.walkers.clear();
  const double x = 5.0, y = 1.7, z = 1.0;
  place.plan.waypoints = {{{-x, -y, z}}, {{x, -y, z}}, {{x, y, z}}, {{-x, y, z}}};
  place.plan.smooth = false;
  place.plan.nose_forward = false;
  place.plan.speed_m_s = 3.0;
  place.plan.acceleration_m_s2 = 3.0;
  return flight;
}

}  // namespace

std::vector<HardFlight> hardFlights() {
  constexpr double kFast = 40.0, kSlow = 10.0;  // Hz
  return {crowd(),
          movedFurniture(),
          dropouts(),
          halfBlocked(),
          allBlocked(),
          allBlockedWithImu(),
          noReturns(),
          noScans(),
          spin(kFast),
          spin(kSlow),
          fastAcceleration(kFast),
          fastAcceleration(kSlow)};
}

}  // namespace kestrel
