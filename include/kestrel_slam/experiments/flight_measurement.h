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

/// A simulated flight to be mapped, and how.
struct FlightTrial {
  std::string name;
  Place place;
  VehicleModel vehicle;
  SlamConfig config;
  RunOptions options;
  std::uint64_t seed = 1;
};

/// Default parameters and the quadrotor with a UTM-30LX in the built-in place of that name. Throws
/// std::invalid_argument for a name that no place has.
FlightTrial flightIn(const std::string& name, const std::string& place_name);

/// The flights of the README's table.
std::vector<FlightTrial> standardFlights();

/// What came out of it, compared with the truth.
struct FlightMeasurement {
  OfflineRun run;
  ReferenceEvaluation error;   ///< against the true trajectory, after the best rigid alignment
  Consistency consistency;     ///< of the errors with the claimed covariances, from the start on
  std::size_t lost = 0;        ///< scans that fitted nowhere
  std::size_t degenerate = 0;  ///< scans that left a direction open
  double max_tilt_deg = 0.0;   ///< of the vehicle
  double max_yaw_rate_rad_s = 0.0;
  std::size_t occupied_cells = 0;
  std::size_t false_cells =
      0;  ///< occupied, but no upright surface is near: a floor or a table top
};

/// Flies and maps. Deterministic. Throws what the simulator and the evaluation throw.
FlightMeasurement measureFlight(const FlightTrial& trial);

/// Distance in the plane from `point` (in world, m) to the nearest upright surface of a box or a
/// cylinder, at any height; infinite where there is none.
double distanceToUprightSurface(const World::Parts& parts, const Eigen::Vector2d& point);

}  // namespace kestrel
