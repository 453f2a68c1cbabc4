// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "kestrel_slam/experiments/flight_measurement.h"

namespace kestrel {

/// One quarter of the scans of a drive.
struct DriveQuarter {
  double median_ms = 0.0;  ///< measured: projection, match and insertion of a scan
  double map_mb = 0.0;     ///< memory of the map at its end
};

/// A long drive over ground that is new all the time: does a scan cost more on a larger map?
struct DriveMeasurement {
  FlightMeasurement flight;
  double length_m = 0.0;       ///< of the true path
  double end_error_m = 0.0;    ///< of the last pose as the first one sees it
  double end_error_deg = 0.0;  ///< of its yaw
  double area_m2 = 0.0;        ///< known cells of the map
  std::array<DriveQuarter, 4> quarters;
};

/// Once around the town with two lasers of 200 m range and no other sensor, as the vehicle of paper
/// 002 around its block of 100 000 m². Different from the defaults is only laser_max_dist, which
/// lets these lasers see as far as they can..
FlightTrial townDrive();
/// The same around the large town, 2.4 km.
FlightTrial largeTownDrive();

/// Drives and maps. Throws what measureFlight throws.
DriveMeasurement measureDrive(const FlightTrial& trial);

}  // namespace kestrel
