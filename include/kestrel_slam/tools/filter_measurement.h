#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/tools/filtered_mapping.h"
#include "kestrel_slam/tools/flight_measurement.h"

namespace kestrel_slam {

/// How the filter's states of one simulated flight compare with the truth, in the map that the
/// first scan begins.
struct FilterMeasurement {
  double xy_rmse_m = 0.0, z_rmse_m = 0.0, velocity_rmse = 0.0;  ///< m, m, m/s
  double tilt_rmse_deg = 0.0, yaw_rmse_deg = 0.0;               ///< tilt: of roll and pitch, each
  double xy_max_m = 0.0;
  /// Largest of (step of odom between two outputs) / (1 mm + what the speed explains).
  double worst_step = 0.0;
  double largest_step_m = 0.0;                               ///< of odom between two outputs
  std::vector<Eigen::Matrix<double, kFilterDim, 1>> errors;  ///< one a second, truth - estimate
  std::vector<double> nees;                                  ///< of the 15 states, one a second
  std::vector<Eigen::Vector<double, 5>> block_nees;          ///< of each block of three
  double imu_us = 0.0;  ///< measured: mean cost of an IMU sample, all included
  // The mapper:
  std::size_t scans = 0, lost = 0, searched = 0;
  double iterations = 0.0;     ///< mean of a scan
  double mapper_rmse_m = 0.0;  ///< of the mapper's own poses that are not lost, without alignment
  FilterStatus status;
};

struct FilterTrial {
  FlightTrial flight;
  PoseFilterConfig filter;
  CouplingOptions coupling;
  double blind_from_s = 0.0, blind_until_s = 0.0;  ///< no scan reaches the mapper meanwhile
};

/// What the filter and the mapper make of the flight. Deterministic but for `imu_us`.
FilterMeasurement measureFilter(const FilterTrial& trial);

}  // namespace kestrel_slam
