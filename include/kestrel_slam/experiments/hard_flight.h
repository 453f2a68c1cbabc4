// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"

namespace kestrel {

/// Limits for the measurement of a hard flight.
struct HardLimits {
  double ate_m = 0.02;           ///< rmse of scans that are not lost
  double jump_m = 0.1;           ///< difference to the true motion between two scans
  std::size_t false_alarms = 0;  ///< scans
  std::size_t missed = 0;        ///< scans
  std::size_t ghost_cells = 10;  ///< (a map has about 2000 occupied cells)
  std::size_t double_cells = 2;
  double recovery_s = 0.5;  ///< from the end of a blocked view to the first scan that is not lost
};

/// A flight with a disturbance: moving objects, missing data or fast motion.
struct HardFlight {
  FlightTrial trial;
  HardLimits limits;
  /// Interval in which the whole view is blocked, s after the start. A lost scan is no false alarm
  /// then.
  double blind_from_s = 0.0, blind_until_s = 0.0;
  bool lost_expected = false;  ///< scans arrive in that interval, but do not show the place
};

/// The built-in hard flights: people, moved furniture, dropouts, blocked views, rotation in place
/// and fast acceleration.
std::vector<HardFlight> hardFlights();

/// The result of a hard flight, compared with the truth.
struct HardFlightMeasurement {
  FlightMeasurement flight;
  double ate_m = 0.0;  ///< rmse of the scans that are not lost, after the best rigid alignment
  /// Largest difference to the true motion between two scans that are not lost.
  double jump_m = 0.0;
  std::size_t lost = 0;
  /// Scans reported as lost, but with an error below 0.2 m and a free view.
  std::size_t false_alarms = 0;
  std::size_t missed = 0;  ///< scans not reported as lost, but with an error above 0.5 m
  /// Occupied cells of the final map that are not near a surface at that time, but near a former
  /// position of a person, of an object or of the vehicle.
  std::size_t ghost_cells = 0;
  std::size_t double_cells = 0;  ///< occupied cells that were never near any surface
  /// From the end of the blocked view to the first scan that is not lost; 0: no blocked view.
  double recovery_s = 0.0;

  /// Lists the values that exceed their limits; empty if there are none.
  std::string failures(const HardLimits& limits) const;
};

/// Simulates and maps the flight. Deterministic. Throws the exceptions of measureFlight().
HardFlightMeasurement measureHardFlight(const HardFlight& flight);

}  // namespace kestrel
