// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/attitude_estimator.h"
#include "measurement.h"

namespace kestrel {
namespace {

/// Derivative of the yaw with respect to the orientation error.
Eigen::RowVector3d yawJacobian(const FilterState& state) {
  const Eigen::Vector3d forward = state.map_R_base * Eigen::Vector3d::UnitX();
  const double level = forward.head<2>().squaredNorm();
  return {-forward.x() * forward.z() / level, -forward.y() * forward.z() / level, 1.0};
}

Linearized<1> heightAbove(double measured, const FilterState& state, double reference) {
  Linearized<1> result;
  result.jacobian.setZero();
  result.jacobian(kPosition + 2) = 1.0;
  result.innovation(0) = measured - (state.position.z() + reference);
  return result;
}

}  // namespace

Linearized<3> linearizePose(const Measurement& measurement, const FilterState& state) {
  Linearized<3> result;
  result.jacobian.setZero();
  result.jacobian.block<2, 2>(0, kPosition).setIdentity();
  result.jacobian.block<1, 3>(2, kOrientation) = yawJacobian(state);
  result.innovation.head<2>() = measurement.value.head<2>() - state.position.head<2>();
  result.innovation(2) = normalizeAngle(measurement.value.z() - yawOf(state.map_R_base));
  return result;
}

Linearized<3> linearizePosition(const Measurement& measurement, const FilterState& state) {
  Linearized<3> result;
  result.jacobian.setZero();
  result.jacobian.block<3, 3>(0, kPosition).setIdentity();
  result.innovation = measurement.value - state.position;
  return result;
}

Linearized<3> linearizeGravity(const Measurement& measurement, const FilterState& state) {
  const Eigen::Vector3d gravity(0.0, 0.0, kGravity);
  const Eigen::Matrix3d base_R_map = state.map_R_base.toRotationMatrix().transpose();
  Linearized<3> result;
  result.jacobian.setZero();
  result.jacobian.block<3, 3>(0, kOrientation) = base_R_map * skew(gravity);
  result.jacobian.block<3, 3>(0, kAccelerometerBias).setIdentity();
  result.innovation = measurement.value - (base_R_map * gravity + state.accelerometer_bias);
  return result;
}

Linearized<6> linearizeStandstill(const Measurement& measurement, const FilterState& state) {
  Linearized<6> result;
  result.jacobian.setZero();
  result.jacobian.block<3, 3>(0, kVelocity).setIdentity();
  result.jacobian.block<3, 3>(3, kGyroBias).setIdentity();
  result.innovation << -state.velocity, measurement.value - state.gyro_bias;
  return result;
}

Linearized<1> linearizeYaw(const Measurement& measurement, const FilterState& state) {
  Linearized<1> result;
  result.jacobian.setZero();
  result.jacobian.block<1, 3>(0, kOrientation) = yawJacobian(state);
  result.innovation(0) = normalizeAngle(measurement.value.x() - yawOf(state.map_R_base));
  return result;
}

Linearized<1> linearizeRange(const Measurement& measurement, const FilterState& state) {
  const Eigen::Vector3d up = state.map_R_base * Eigen::Vector3d::UnitZ();
  const double height = state.position.z() - state.ground;
  Linearized<1> result;
  result.jacobian.setZero();
  result.jacobian(kPosition + 2) = 1.0 / up.z();
  result.jacobian(kGround) = -1.0 / up.z();
  result.jacobian.block<1, 2>(0, kOrientation) =
      height / (up.z() * up.z()) * Eigen::RowVector2d(-up.y(), up.x());
  result.innovation(0) = measurement.value.x() - height / up.z();
  return result;
}

Linearized<1> linearizeFloorHeight(const Measurement& measurement, const FilterState& state) {
  return heightAbove(measurement.value.x(), state, 0.0);
}

Linearized<1> linearizeBarometer(const Measurement& measurement, const FilterState& state) {
  Linearized<1> result = heightAbove(measurement.value.x(), state, state.barometer_offset);
  result.jacobian(kBarometerOffset) = 1.0;
  return result;
}

}  // namespace kestrel
