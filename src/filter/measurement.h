// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/filter/filter_types.h"

namespace kestrel {

/// One measurement of any sensor, in the form in which the timeline keeps it.
struct Measurement {
  FilterSensor sensor = FilterSensor::kPose;
  double stamp = 0.0;
  /// kPose: x, y, yaw. kPosition: x, y, z. kGravityDirection: specific force in base.
  /// kZeroVelocity: mean rate of the gyro in base. Others: one value in x.
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< others: only the first element
  bool place = false;    ///< kPose: whoever says it is right, the gate does not count
  bool counted = false;  ///< its verdict is in the counts already
};

/// What became of a measurement: accepted where `reason` is empty.
struct Verdict {
  std::string reason;
  bool reinitialized = false;  ///< the pose or height was taken over as it is
};

/// Applies `measurement` to the state, which has to be that of its stamp. Rejected measurements
/// change nothing but what the state remembers of rejections.
Verdict apply(const Measurement& measurement, const PoseFilterConfig& config, FilterState& state);

/// A measurement that the state predicts, linearized: innovation = measured - predicted.
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

/// The value that `probability` of all chi-square variables with so many degrees of freedom stay
/// below (Wilson and Hilferty's approximation: 3 % too much at worst for gates).
double chiSquareQuantile(double probability, int freedom);

}  // namespace kestrel
