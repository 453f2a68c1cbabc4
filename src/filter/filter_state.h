// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/filter/pose_filter_config.h"

namespace kestrel {

/// The two states beside those of FilterOutput: what the height sensors refer to. They are
/// estimated together with the others, so that a height that was learned from the filter never
/// counts as news.
constexpr int kBarometerOffset = kFilterDim;  ///< what a barometer reads at z = 0, m
constexpr int kGround = kFilterDim + 1;       ///< height of what is below the range finder, m
constexpr int kStateDim = kFilterDim + 2;

using StateVector = Eigen::Matrix<double, kStateDim, 1>;
using StateMatrix = Eigen::Matrix<double, kStateDim, kStateDim>;

/// What the IMU measures over a step, in base.
struct ImuInput {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();   ///< rad/s
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< specific force, m/s²
  bool rate_saturated = false;
  bool force_saturated = false;
};

/// Estimate, covariance, and what the measurement models remember: a value, so that the filter can
/// go back to an earlier one and repeat everything since then.
struct FilterState {
  double stamp = 0.0;
  Eigen::Quaterniond map_R_base = Eigen::Quaterniond::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< in map, m
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< in map, m/s
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();
  double barometer_offset = 0.0;
  double ground = 0.0;
  StateMatrix covariance = StateMatrix::Zero();

  bool reinitialized = false;           ///< the place in map is known
  double aided_stamp = -1e18;           ///< of the last pose or position that was accepted, s
  double rejected_since = -1.0;         ///< stamp of the first pose rejected in a row; < 0: none
  double height_rejected_since = -1.0;  ///< the same of readings of the range finder
  double range_stamp = -1e18;           ///< of the last of them, s,
  double range_m = 0.0;                 ///< and how far down it saw, m
  double step_height = 0.0;  ///< ground that rejected readings of the range finder suggest, m
  int step_readings = 0;     ///< how many in a row
};

/// Derivative of the next error state with respect to this one, for a step of `dt` seconds.
StateMatrix transition(const FilterState& state, const ImuInput& input, double dt);

/// Moves the estimate alone (paper 001 eq. 1-3 with biases, trapezoidal).
void moveEstimate(const ImuInput& input, double dt, FilterState& state);

/// Moves estimate and covariance; the same as with transition(), but only where that is not the
/// identity.
void propagate(const ImuInput& input, double dt, const PoseFilterConfig& config,
               FilterState& state);

/// Forgets what a gap of `dt` seconds without IMU makes uncertain.
void addGap(double dt, FilterState& state);

/// Adds an error state to the estimate.
void inject(const StateVector& error, FilterState& state);

/// The error state that leads from `estimate` to `truth`.
StateVector errorBetween(const FilterState& estimate, const FilterState& truth);

/// Finite, and no variance is negative.
bool isHealthy(const FilterState& state);

/// The matrix of the cross product.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

}  // namespace kestrel
