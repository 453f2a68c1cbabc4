// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/evaluation/consistency.h"
#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/simulation/flight_plan.h"
#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

/// A simulated flight with all settings for its mapping.
struct FlightTrial {
  std::string name;
  Place place;
  VehicleModel vehicle;
  SlamConfig config;
  RunOptions options;
  std::uint64_t seed = 1;
};

/// A trial called `name` with default parameters and a quadrotor with a UTM-30LX in the built-in
/// place `place_name`. Throws std::invalid_argument if there is no such place.
FlightTrial flightIn(const std::string& name, const std::string& place_name);

/// The standard flights of the benchmark (see measure_flights).
std::vector<FlightTrial> standardFlights();

/// The result of a flight, compared with the truth.
struct FlightMeasurement {
  OfflineRun run;
  ReferenceEvaluation
      error;                ///< with respect to the true trajectory, after the best rigid alignment
  Consistency consistency;  ///< of errors and estimated covariances, relative to the first pose
  std::size_t lost = 0;     ///< scans in the state "lost"
  std::size_t degenerate = 0;  ///< scans with an unobservable direction
  double max_tilt_deg = 0.0;   ///< of the vehicle
  double max_yaw_rate_rad_s = 0.0;
  std::size_t occupied_cells = 0;
  /// Occupied cells without an upright surface nearby, for example from the floor or a table top.
  std::size_t false_cells = 0;
};

/// Simulates and maps the flight. Deterministic. Throws the exceptions of the simulator and of
/// evaluateReference().
FlightMeasurement measureFlight(const FlightTrial& trial);

/// An occupied cell farther than this from every upright surface is false, m. Allows for two cells
/// and the noise of the laser.
constexpr double kFalseDistance = 0.15;

/// Distance in the plane from `point` (in world, m) to the nearest upright surface of a box or
/// cylinder, at any height; infinite if there is none.
double distanceToUprightSurface(const World::Parts& parts, const Eigen::Vector2d& point);

}  // namespace kestrel
