// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <functional>

#include "../../src/filter/filter_state.h"
#include "../../src/filter/measurement.h"
#include "kestrel_slam/sensor/attitude_estimator.h"

namespace kestrel {
namespace {

constexpr double kStep = 1e-6;       // of the finite differences
constexpr double kTolerance = 2e-8;  // of a derivative: rounding error divided by the step

/// Tilted, rotated, moving and with biases, so that no term is zero.
FilterState someState() {
  FilterState state;
  state.map_R_base = rotationBy({0.2, -0.3, 2.0});
  state.position = {1.0, -2.0, 1.5};
  state.velocity = {0.7, 0.4, -0.2};
  state.gyro_bias = {0.01, -0.02, 0.03};
  state.accelerometer_bias = {0.1, 0.2, -0.1};
  state.barometer_offset = 100.0;
  state.ground = 0.7;
  return state;
}

/// The derivative of `f` at `state` with respect to the error state, by central differences.
template <int Rows>
Eigen::Matrix<double, Rows, kStateDim> differences(
    const FilterState& state,
    const std::function<Eigen::Matrix<double, Rows, 1>(const FilterState&)>& f) {
  Eigen::Matrix<double, Rows, kStateDim> result;
  for (int i = 0; i < kStateDim; ++i) {
    FilterState above = state, below = state;
    inject(kStep * StateVector::Unit(i), above);
    inject(-kStep * StateVector::Unit(i), below);
    result.col(i) = (f(above) - f(below)) / (2.0 * kStep);
  }
  return result;
}

/// predicted = measured - innovation, so the derivative of the prediction is minus that of the
/// innovation.
template <int Rows>
void expectJacobian(Linearized<Rows> (*linearize)(const Measurement&, const FilterState&),
                    const Measurement& measurement) {
  const FilterState state = someState();
  const auto expected = differences<Rows>(state, [&](const FilterState& s) {
    return Eigen::Matrix<double, Rows, 1>(-linearize(measurement, s).innovation);
  });
  const auto found = linearize(measurement, state).jacobian;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), kTolerance) << "found\n"
                                                                  << found << "\nexpected\n"
                                                                  << expected;
}

TEST(Jacobian, EveryMeasurementAgreesWithFiniteDifferences) {
  Measurement m;
  m.value = {0.5, 0.1, 0.2};
  expectJacobian<3>(linearizePose, m);
  expectJacobian<3>(linearizePosition, m);
  expectJacobian<3>(linearizeGravity, m);
  expectJacobian<6>(linearizeStandstill, m);
  expectJacobian<1>(linearizeYaw, m);
  expectJacobian<1>(linearizeRange, m);
  expectJacobian<1>(linearizeFloorHeight, m);
  expectJacobian<1>(linearizeBarometer, m);
}

InertialInput someInput() {
  InertialInput input;
  input.rate = {0.8, -0.5, 1.7};
  input.force = {1.0, -2.0, 10.5};
  return input;
}

TEST(Jacobian, TransitionAgreesWithFiniteDifferences) {
  const FilterState state = someState();
  const InertialInput input = someInput();
  for (const double dt : {0.0025, 0.01}) {
    FilterState moved = state;
    moveEstimate(input, dt, moved);
    const auto expected = differences<kStateDim>(state, [&](const FilterState& start) {
      FilterState end = start;
      moveEstimate(input, dt, end);
      return errorBetween(moved, end);
    });
    const StateMatrix found = transition(state, input, dt);
    // The transition neglects the rotation of the bias axes within half a step: rate dt / 4,
    // relative to a term of dt² / 2.
    const double allowed = kTolerance + 3e-4 * dt;
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), allowed) << found - expected;
    EXPECT_GT((StateMatrix::Identity() - expected).cwiseAbs().maxCoeff(), 0.9 * dt);
  }
}

TEST(Jacobian, CovarianceIsPropagatedWithTheTransition) {
  FilterState state = someState();
  StateMatrix root;
  for (int i = 0; i < root.size(); ++i) root(i) = 0.01 * ((7 * i) % 11 - 5);
  state.covariance = root * root.transpose();
  const StateMatrix f = transition(state, someInput(), 0.01);
  const StateMatrix expected = f * state.covariance * f.transpose();
  PoseFilterConfig config;
  config.noise.gyro_noise = config.noise.accelerometer_noise = 1e-9;
  config.noise.gyro_bias_walk = config.noise.accelerometer_bias_walk = 0.0;
  config.height.barometer_drift = 0.0;
  propagate(someInput(), 0.01, config, state);
  EXPECT_LT((state.covariance - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Jacobian, ErrorBetweenIsTheInverseOfInject) {
  StateVector error;
  for (int i = 0; i < kStateDim; ++i) error(i) = 0.05 * (i + 1) - 0.4;
  const FilterState state = someState();
  FilterState moved = state;
  inject(error, moved);
  EXPECT_LT((errorBetween(state, moved) - error).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace kestrel
