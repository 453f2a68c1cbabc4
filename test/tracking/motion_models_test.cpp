// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_models.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

template <int N>
void expectJacobian(const MotionModel<N>& model, const Eigen::Matrix<double, N, 1>& state) {
  constexpr double kStep = 1e-6, kSeconds = 0.7;
  const Transition<N> at = model(state, kSeconds);
  for (int i = 0; i < N; ++i) {
    Eigen::Matrix<double, N, 1> step = Eigen::Matrix<double, N, 1>::Zero();
    step(i) = kStep;
    const Eigen::Matrix<double, N, 1> slope =
        (model(state + step, kSeconds).mean - model(state - step, kSeconds).mean) / (2.0 * kStep);
    EXPECT_LT((slope - at.jacobian.col(i)).norm(), 1e-7) << i;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> solver(at.noise);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-12);
}

TEST(MotionModels, JacobiansEqualFiniteDifferences) {
  Eigen::Matrix<double, 5, 1> state;
  state << 3.0, -2.0, 1.5, 0.4, 0.6;
  expectJacobian<5>(standing<5, 2>(0.1, 0.5), state);
  expectJacobian<5>(constantVelocity<5, 2>(2.0, 0.3), state);
  expectJacobian<5>(constantTurn<2>(2.0, 0.3), state);
  state(4) = 1e-9;
  expectJacobian<5>(constantTurn<2>(2.0, 0.3), state);
  Eigen::Matrix<double, 7, 1> in_space;
  in_space << 3.0, -2.0, 1.0, 1.5, 0.4, 0.2, -0.8;
  expectJacobian<7>(constantTurn<3>(2.0, 0.3), in_space);
}

TEST(MotionModels, TurnIsACircle) {
  // A speed of 1 m/s and a turn rate of pi/2 rad/s: a quarter of a circle of radius 2/pi.
  Eigen::Matrix<double, 5, 1> state;
  state << 0.0, 0.0, 1.0, 0.0, kPi / 2.0;
  const Transition<5> turned = constantTurn<2>(1.0, 1.0)(state, 1.0);
  EXPECT_NEAR(turned.mean(0), 2.0 / kPi, 1e-12);
  EXPECT_NEAR(turned.mean(1), 2.0 / kPi, 1e-12);
  EXPECT_NEAR(turned.mean(2), 0.0, 1e-12);
  EXPECT_NEAR(turned.mean(3), 1.0, 1e-12);
}

TEST(MotionModels, SlowTurnIsContinuous) {
  const MotionModel<5> model = constantTurn<2>(1.0, 1.0);
  Eigen::Matrix<double, 5, 1> state;
  state << 0.0, 0.0, 1.0, 0.5, 0.99e-4;
  const Transition<5> below = model(state, 1.0);
  state(4) = 1.01e-4;
  const Transition<5> above = model(state, 1.0);
  EXPECT_LT((below.mean - above.mean).norm(), 1e-5);
  EXPECT_LT((below.jacobian - above.jacobian).norm(), 1e-5);
}

TEST(MotionModels, StandingHasNoVelocity) {
  Eigen::Matrix<double, 4, 1> state(1.0, 2.0, 3.0, 4.0);
  const Transition<4> stands = standing<4, 2>(0.1, 0.5)(state, 4.0);
  EXPECT_EQ(stands.mean, (Eigen::Matrix<double, 4, 1>(1.0, 2.0, 0.0, 0.0)));
  EXPECT_NEAR(stands.noise(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(stands.noise(2, 2), 0.25, 1e-12);
}

}  // namespace
}  // namespace kestrel
