// SPDX-License-Identifier: BSD-3-Clause
#include "filter_state.h"

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/square.h"
#include "kestrel_slam/sensor/attitude_estimator.h"

namespace kestrel {
namespace {

// Noise of a saturated reading, which only shows the direction.
constexpr double kSaturatedGyroNoise = 1.0;            // rad/s/sqrt(Hz)
constexpr double kSaturatedAccelerometerNoise = 10.0;  // m/s²/sqrt(Hz)

// Unknown motion in a gap, in addition to the continued one.
constexpr double kGapRate = 0.5;          // rad/s
constexpr double kGapAcceleration = 2.0;  // m/s²

/// The blocks of the transition that are neither zero nor identity.
struct Step {
  Eigen::Matrix3d orientation_by_bias;      ///< -d orientation / d gyro bias
  Eigen::Matrix3d velocity_by_orientation;  ///< d velocity / d orientation
  Eigen::Matrix3d velocity_by_bias;         ///< d velocity / d gyro bias
};

/// Orientation in the middle of the step.
Eigen::Quaterniond middle(const InertialInput& input, double dt, const FilterState& state) {
  return state.map_R_base * rotationBy(0.5 * dt * (input.rate - state.gyro_bias));
}

Step stepOf(const FilterState& state, const InertialInput& input, double dt) {
  const Eigen::Matrix3d map_R_middle = middle(input, dt, state).toRotationMatrix();
  const Eigen::Vector3d force = map_R_middle * (input.force - state.accelerometer_bias);
  Step step;
  step.orientation_by_bias = dt * map_R_middle;
  step.velocity_by_orientation = -dt * skew(force);
  step.velocity_by_bias = -0.5 * step.velocity_by_orientation * step.orientation_by_bias;
  return step;
}

/// Multiplies `matrix` from the left with the transition. The rows of the biases do not change.
void multiply(const Step& step, double dt, StateMatrix& matrix) {
  using Rows = Eigen::Matrix<double, 3, kStateDim>;
  const Rows velocity_change = step.velocity_by_orientation * matrix.middleRows<3>(kOrientation) +
                               step.velocity_by_bias * matrix.middleRows<3>(kGyroBias) -
                               step.orientation_by_bias * matrix.middleRows<3>(kAccelerometerBias);
  matrix.middleRows<3>(kPosition) +=
      dt * matrix.middleRows<3>(kVelocity) + 0.5 * dt * velocity_change;
  matrix.middleRows<3>(kVelocity) += velocity_change;
  matrix.middleRows<3>(kOrientation) -= step.orientation_by_bias * matrix.middleRows<3>(kGyroBias);
}

void addNoise(const InertialInput& input, double dt, const PoseFilterConfig& config,
              StateMatrix& p) {
  const ImuNoiseConfig& noise = config.noise;
  const double gyro = square(input.rate_saturated ? kSaturatedGyroNoise : noise.gyro_noise);
  const double accelerometer =
      square(input.force_saturated ? kSaturatedAccelerometerNoise : noise.accelerometer_noise);
  const double gyro_walk = square(noise.gyro_bias_walk) * dt;
  const double accelerometer_walk = square(noise.accelerometer_bias_walk) * dt;
  for (int i = 0; i < 3; ++i) {
    p(kOrientation + i, kOrientation + i) += gyro * dt;
    p(kVelocity + i, kVelocity + i) += accelerometer * dt;
    p(kPosition + i, kPosition + i) += accelerometer * dt * dt * dt / 3.0;
    p(kPosition + i, kVelocity + i) += 0.5 * accelerometer * dt * dt;
    p(kVelocity + i, kPosition + i) += 0.5 * accelerometer * dt * dt;
    p(kGyroBias + i, kGyroBias + i) += gyro_walk;
    p(kAccelerometerBias + i, kAccelerometerBias + i) += accelerometer_walk;
  }
  p(kBarometerOffset, kBarometerOffset) += square(config.height.barometer_drift) * dt;
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d result;
  result << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return result;
}

StateMatrix transition(const FilterState& state, const InertialInput& input, double dt) {
  StateMatrix result = StateMatrix::Identity();
  multiply(stepOf(state, input, dt), dt, result);
  return result;
}

void moveEstimate(const InertialInput& input, double dt, FilterState& state) {
  const Eigen::Vector3d gravity(0.0, 0.0, kGravity);
  const Eigen::Vector3d acceleration =
      middle(input, dt, state) * (input.force - state.accelerometer_bias) - gravity;
  state.map_R_base =
      (state.map_R_base * rotationBy(dt * (input.rate - state.gyro_bias))).normalized();
  state.position += dt * state.velocity + 0.5 * dt * dt * acceleration;
  state.velocity += dt * acceleration;
  state.stamp += dt;
}

void propagate(const InertialInput& input, double dt, const PoseFilterConfig& config,
               FilterState& state) {
  const Step step = stepOf(state, input, dt);
  multiply(step, dt, state.covariance);
  state.covariance.transposeInPlace();  // symmetric before, so this multiplies from the right
  multiply(step, dt, state.covariance);
  addNoise(input, dt, config, state.covariance);
  moveEstimate(input, dt, state);
}

void addGap(double dt, FilterState& state) {
  const double turned = square(kGapRate * dt), gained = square(kGapAcceleration * dt);
  for (int i = 0; i < 3; ++i) {
    state.covariance(kOrientation + i, kOrientation + i) += turned;
    state.covariance(kVelocity + i, kVelocity + i) += gained;
    state.covariance(kPosition + i, kPosition + i) += 0.25 * gained * dt * dt;
  }
}

void inject(const StateVector& error, FilterState& state) {
  state.map_R_base = (rotationBy(error.segment<3>(kOrientation)) * state.map_R_base).normalized();
  state.position += error.segment<3>(kPosition);
  state.velocity += error.segment<3>(kVelocity);
  state.gyro_bias += error.segment<3>(kGyroBias);
  state.accelerometer_bias += error.segment<3>(kAccelerometerBias);
  state.barometer_offset += error(kBarometerOffset);
  state.ground += error(kGround);
}

StateVector errorBetween(const FilterState& estimate, const FilterState& truth) {
  StateVector error;
  const Eigen::AngleAxisd turn(truth.map_R_base * estimate.map_R_base.conjugate());
  const double angle = normalizeAngle(turn.angle());
  error.segment<3>(kOrientation) = angle * turn.axis();
  error.segment<3>(kPosition) = truth.position - estimate.position;
  error.segment<3>(kVelocity) = truth.velocity - estimate.velocity;
  error.segment<3>(kGyroBias) = truth.gyro_bias - estimate.gyro_bias;
  error.segment<3>(kAccelerometerBias) = truth.accelerometer_bias - estimate.accelerometer_bias;
  error(kBarometerOffset) = truth.barometer_offset - estimate.barometer_offset;
  error(kGround) = truth.ground - estimate.ground;
  return error;
}

bool isHealthy(const FilterState& state) {
  const bool finite = state.map_R_base.coeffs().allFinite() && state.position.allFinite() &&
                      state.velocity.allFinite() && state.gyro_bias.allFinite() &&
                      state.accelerometer_bias.allFinite() && state.covariance.allFinite();
  return finite && (state.covariance.diagonal().array() >= 0.0).all();
}

}  // namespace kestrel
