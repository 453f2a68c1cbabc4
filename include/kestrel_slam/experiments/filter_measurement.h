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

/// Errors of the filter in one simulated flight, in the map frame that the first scan defines.
struct FilterMeasurement {
  double xy_rmse_m = 0.0, z_rmse_m = 0.0;
  double z_end_m = 0.0;                            ///< error at the end
  double velocity_rmse = 0.0;                      ///< m/s
  double tilt_rmse_deg = 0.0, yaw_rmse_deg = 0.0;  ///< tilt: roll and pitch together, per axis
  double xy_max_m = 0.0;
  /// Motion in odom between two outputs: the largest step, and the largest ratio of the step to the
  /// true motion. 1 mm is added to both parts of the ratio.
  double largest_step_m = 0.0, worst_step = 0.0;
  double return_error_m = 0.0;  ///< horizontal error when scans come back; 0: no scan gap
  std::vector<double> nees;     ///< of the 15 states, one value per second
  std::vector<std::array<double, 5>> block_nees;  ///< of each block of three states, in state order

  /// Counts of the mapper. fallbacks: scans whose first prediction had a low score.
  std::size_t scans = 0, lost = 0, searched = 0, fallbacks = 0;
  double iterations = 0.0;     ///< mean per scan
  double mapper_rmse_m = 0.0;  ///< of the mapper poses that are not lost, in the same map
  FilterStatus status;
};

struct FilterTrial {
  FlightTrial flight;
  PoseFilterConfig filter;
  /// Delivers the mapper's pose to the filter 5 ms after the scan.
  CouplingOptions coupling{true, true, true, true, 0.005};
  double blind_from_s = 0.0, blind_until_s = 0.0;  ///< no scans in this interval
};

/// Runs the filter and the mapper on the flight, with all messages in the order of their arrival.
/// Deterministic.
FilterMeasurement measureFilter(const FilterTrial& trial);

/// Mean processor time of the filter per IMU sample, us. The IMU has 400 Hz. The filter also gets
/// mapper poses at 40 Hz with a delay of 20 ms, a range finder and a barometer.
double measureImuCost(double duration_s);

}  // namespace kestrel
