// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "kestrel_slam/experiments/flight_measurement.h"
#include "kestrel_slam/pipeline/pipeline.h"

namespace kestrel {

using FilterError = Eigen::Matrix<double, kFilterDim, 1>;

/// How the filter's states of one simulated flight compare with the truth, in the map that the
/// first scan begins.
struct FilterMeasurement {
  double xy_rmse_m = 0.0, z_rmse_m = 0.0;
  double z_end_m = 0.0;                            ///< error at the end
  double velocity_rmse = 0.0;                      ///< m/s
  double tilt_rmse_deg = 0.0, yaw_rmse_deg = 0.0;  ///< tilt: of roll and pitch, each
  double xy_max_m = 0.0;
  /// Of odom between two outputs: the largest step, and the largest quotient of step and what the
  /// true motion explains, both plus a millimeter.
  double largest_step_m = 0.0, worst_step = 0.0;
  double return_error_m = 0.0;  ///< position in the plane when scans come back; 0: always there
  std::vector<double> nees;     ///< of the 15 states, one a second
  std::vector<std::array<double, 5>> block_nees;  ///< of every three of them, in their order

  /// Of the mapper; fallbacks: scans whose first prediction fitted badly.
  std::size_t scans = 0, lost = 0, searched = 0, fallbacks = 0;
  double iterations = 0.0;     ///< mean of a scan
  double mapper_rmse_m = 0.0;  ///< of the mapper's poses that are not lost, in the same map
  FilterStatus status;
};

struct FilterTrial {
  FlightTrial flight;
  PoseFilterConfig filter;
  /// The mapper's pose reaches the filter 5 ms after the scan.
  CouplingOptions coupling{true, true, true, true, 0.005};
  double blind_from_s = 0.0, blind_until_s = 0.0;  ///< no scan comes meanwhile
};

/// What the filter and the mapper make of the flight, all messages in the order of their arrival.
/// Deterministic.
FilterMeasurement measureFilter(const FilterTrial& trial);

/// Mean processor time of the filter per IMU sample, us: 400 Hz, with a mapper's pose of 40 Hz that
/// is 20 ms late, a range finder and a barometer.
double measureImuCost(double duration_s);

}  // namespace kestrel
