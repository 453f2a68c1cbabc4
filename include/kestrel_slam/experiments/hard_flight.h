// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"

namespace kestrel {

/// What a hard flight must not exceed.
struct HardLimits {
  double ate_m = 0.02;           ///< rmse of the poses that are not lost
  double jump_m = 0.1;           ///< between two scans, beyond the true motion
  std::size_t false_alarms = 0;  ///< scans
  std::size_t missed = 0;        ///< scans
  std::size_t ghost_cells = 10;  ///< of some 2000 that are walls
  std::size_t double_cells = 2;
  double recovery_s = 0.5;  ///< from the end of a blocked view to the first scan that is found
};

/// A flight in which something goes wrong around the vehicle.
struct HardFlight {
  FlightTrial trial;
  HardLimits limits;
  /// Whole view blocked, s after the start: lost there is true whatever the error is.
  double blind_from_s = 0.0, blind_until_s = 0.0;
  bool lost_is_true = false;  ///< scans come in that time, and they show nothing of the place
};

/// People, moved furniture, dropouts, blocked views, a rotation in place and a fast start.
std::vector<HardFlight> hardFlights();

/// What came out of it, compared with the truth.
struct HardFlightMeasurement {
  FlightMeasurement flight;
  double ate_m = 0.0;   ///< rmse of the scans that are not lost, after the best rigid alignment
  double jump_m = 0.0;  ///< largest motion between two scans that are not lost, less the true one
  std::size_t lost = 0;
  std::size_t false_alarms = 0;  ///< declared lost with an error below 0.2 m and a free view
  std::size_t missed = 0;        ///< not declared lost with an error above 0.5 m
  /// Occupied cells of the final map that stand nowhere near a surface of that time, but where a
  /// person or a thing was, or where the vehicle flew,
  std::size_t ghost_cells = 0;
  std::size_t double_cells = 0;  ///< and those that stand where nothing ever was
  double recovery_s = 0.0;  ///< from the end of the blind time to the first scan found; 0: none

  /// Empty, or what exceeds its limit.
  std::string failures(const HardLimits& limits) const;
};

/// Flies and maps. Deterministic. Throws what measureFlight throws.
HardFlightMeasurement measureHardFlight(const HardFlight& flight);

}  // namespace kestrel
