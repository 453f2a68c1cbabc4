// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/filter/filter_types.h"

namespace kestrel {

/// A measurement of any sensor, as stored in the timeline.
struct Measurement {
  FilterSensor sensor = FilterSensor::kPose;
  double stamp = 0.0;
  /// kPose: x, y, yaw. kPosition: x, y, z. kGravityDirection: specific force in the base frame.
  /// kZeroVelocity: mean rate of the gyro in the base frame. Others: one value in x.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< single values: only the first element
  /// kPose: direction in map along which the pose is only predicted; zero: none.
  Eigen::Vector2d unobservable = Eigen::Vector2d::Zero();
  bool bypass_gate = false;  ///< kPose: set by the user; always accepted
  bool counted = false;      ///< its verdict was already counted
};

/// Result of a measurement: accepted if `reason` is empty.
struct Verdict {
  std::string reason;
  bool reinitialized = false;  ///< the filter was reinitialized to the measurement
};

/// Applies `measurement` to the state at its stamp. A rejected measurement only changes the memory
/// of rejections in the state.
Verdict apply(const Measurement& measurement, const PoseFilterConfig& config, FilterState& state);

/// Linearization of a measurement: innovation = measured - predicted.
template <int Rows>
struct Linearized {
  Eigen::Matrix<double, Rows, 1> innovation;
  Eigen::Matrix<double, Rows, kStateDim> jacobian;
};

Linearized<3> linearizePose(const Measurement& measurement, const FilterState& state);
Linearized<3> linearizePosition(const Measurement& measurement, const FilterState& state);
Linearized<3> linearizeGravity(const Measurement& measurement, const FilterState& state);
Linearized<6> linearizeStandstill(const Measurement& measurement, const FilterState& state);
Linearized<1> linearizeYaw(const Measurement& measurement, const FilterState& state);
Linearized<1> linearizeRange(const Measurement& measurement, const FilterState& state);
Linearized<1> linearizeFloorHeight(const Measurement& measurement, const FilterState& state);
Linearized<1> linearizeBarometer(const Measurement& measurement, const FilterState& state);

/// Quantile of the chi-square distribution with `freedom` degrees of freedom (approximation of
/// Wilson and Hilferty; at most 3 % too large for gates).
double chiSquareQuantile(double probability, int freedom);

}  // namespace kestrel
