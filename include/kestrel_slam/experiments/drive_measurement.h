// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "kestrel_slam/experiments/flight_measurement.h"

namespace kestrel {

/// One quarter of the scans of a drive.
struct DriveQuarter {
  double median_ms = 0.0;  ///< measured time of a scan: projection, matching and insertion
  double map_mb = 0.0;     ///< memory of the map at the end of the quarter
};

/// A long drive through new terrain. Shows whether the time per scan grows with the size of the
/// map.
struct DriveMeasurement {
  FlightMeasurement flight;
  double length_m = 0.0;       ///< of the true path
  double end_error_m = 0.0;    ///< of the last pose relative to the first pose
  double end_error_deg = 0.0;  ///< yaw error of the last pose relative to the first pose
  double area_m2 = 0.0;        ///< area of the known cells
  std::array<DriveQuarter, 4> quarters;
};

/// One loop around the town (1.2 km) with two lasers of 200 m range and no other sensor, similar to
/// the outdoor experiment of [Xie 2010]. All parameters are defaults, except for laser_max_dist,
/// which is set to the range of the lasers.
FlightTrial townDrive();
/// The same around the large town (2.4 km).
FlightTrial largeTownDrive();
/// The same around the sparse town, where up to 50 m of the road have no house.
FlightTrial sparseTownDrive();

/// Simulates and maps the drive. Throws the exceptions of measureFlight().
DriveMeasurement measureDrive(const FlightTrial& trial);

}  // namespace kestrel
