// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/filter/pose_filter_config.h"

namespace kestrel {

/// Two states in addition to those of FilterOutput: the references of the height sensors. They are
/// estimated together with the others, so that the correlation is known and no information is used
/// twice.
constexpr int kBarometerOffset = kFilterDim;  ///< reading of the barometer at z = 0, m
constexpr int kGround = kFilterDim + 1;       ///< height of the surface below the range finder, m
constexpr int kStateDim = kFilterDim + 2;

using StateVector = Eigen::Matrix<double, kStateDim, 1>;
using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

/// Mean IMU reading over a step, in the base frame.
struct InertialInput {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< specific force, m/s²
  bool rate_saturated = false;
  bool force_saturated = false;
};

/// Estimate, covariance, and the memory of the measurement models. A value type, so that the filter
/// can go back to an earlier state and repeat all later steps.
struct FilterState {
  double stamp = 0.0;
  Eigen::Quaterniond map_R_base = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();            ///< in the map frame, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            ///< in the map frame, m/s
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           ///< in the base frame, rad/s
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< in the base frame, m/s²
  double barometer_offset = 0.0;
  double ground = 0.0;
  StateMatrix covariance = StateMatrix::Zero();

  bool reinitialized = false;         ///< the pose in the map is known
  double aided_stamp = -1e18;         ///< stamp of the last accepted pose or position, s
  double partly_aided_stamp = -1e18;  ///< the same for a pose with an unobservable direction, s
  /// Stamp of the first of the poses rejected in a row, s; < 0: none.
  double rejected_since = -1.0;
  double height_rejected_since = -1.0;  ///< the same for the range finder
  double range_stamp = -1e18;           ///< stamp of the last reading of the range finder, s,
  double range_m = 0.0;                 ///< and its vertical distance, m
  double step_height = 0.0;  ///< height of the surface below according to rejected readings, m
  int step_readings = 0;     ///< number of consecutive readings that agree with it
};

/// Derivative of the next error state with respect to the current one, for a step of `dt` seconds.
StateMatrix transition(const FilterState& state, const InertialInput& input, double dt);

/// Propagates the estimate only [Kohlbrecher 2011, eq. 1-3, with biases; trapezoidal].
void moveEstimate(const InertialInput& input, double dt, FilterState& state);

/// Propagates estimate and covariance. Equal to a product with transition(), but skips its zeros
/// and ones.
void propagate(const InertialInput& input, double dt, const PoseFilterConfig& config,
               FilterState& state);

/// Adds the uncertainty of a gap of `dt` seconds without IMU.
void addGap(double dt, FilterState& state);

/// Adds an error state to the estimate.
void inject(const StateVector& error, FilterState& state);

/// The error state from `estimate` to `truth`.
StateVector errorBetween(const FilterState& estimate, const FilterState& truth);

/// Whether all values are finite and no variance is negative.
bool isHealthy(const FilterState& state);

/// The cross product matrix of `v`.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

}  // namespace kestrel
