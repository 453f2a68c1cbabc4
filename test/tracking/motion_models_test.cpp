// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_models.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

template <int N>
struct Gaussian {
  Eigen::Matrix<double, N, 1> mean;
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Zero();

  Gaussian moved(const MotionModel<N>& model, double seconds) const {
    Gaussian result = *this;
    model(seconds, result.mean, result.covariance);
    return result;
  }
};

/// The covariance is F P F' + Q, with the slope F of the mean and a noise Q that P does not change.
template <int N>
void expectCovariance(const MotionModel<N>& model, const Eigen::Matrix<double, N, 1>& state) {
  using Matrix = Eigen::Matrix<double, N, N>;
  constexpr double kStep = 1e-6, kSeconds = 0.7;
  Matrix slope;
  for (int i = 0; i < N; ++i) {
    Eigen::Matrix<double, N, 1> step = Eigen::Matrix<double, N, 1>::Zero();
    step(i) = kStep;
    slope.col(i) = (Gaussian<N>{state + step}.moved(model, kSeconds).mean -
                    Gaussian<N>{state - step}.moved(model, kSeconds).mean) /
                   (2.0 * kStep);
  }
  const Matrix noise = Gaussian<N>{state}.moved(model, kSeconds).covariance;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(noise);
  EXPECT_GT(solver.eigenvalues().minCoeff(), -1e-12);
  Matrix factor;  // of a covariance that correlates everything with everything
  for (int i = 0; i < N * N; ++i) factor(i) = std::sin(i + 1.0);
  const Matrix covariance = factor * factor.transpose();
  const Matrix moved = Gaussian<N>{state, covariance}.moved(model, kSeconds).covariance;
  const Matrix expected = slope * covariance * slope.transpose() + noise;
  EXPECT_LT((moved - expected).norm(), 1e-6 * expected.norm());
}

TEST(MotionModels, CovariancesFollowFiniteDifferences) {
  Eigen::Matrix<double, 5, 1> state;
  state << 3.0, -2.0, 1.5, 0.4, 0.6;
  expectCovariance<5>(standing<5, 2>(0.1, 0.5), state);
  expectCovariance<5>(constantVelocity<5, 2>(2.0, 0.3), state);
  expectCovariance<5>(constantTurn<2>(2.0, 0.3), state);
  state(4) = 1e-9;
  expectCovariance<5>(constantTurn<2>(2.0, 0.3), state);
  Eigen::Matrix<double, 7, 1> in_space;
  in_space << 3.0, -2.0, 1.0, 1.5, 0.4, 0.2, -0.8;
  expectCovariance<7>(constantTurn<3>(2.0, 0.3), in_space);
}

TEST(MotionModels, TurnIsACircle) {
  // A speed of 1 m/s and a turn rate of pi/2 rad/s: a quarter of a circle of radius 2/pi.
  Eigen::Matrix<double, 5, 1> state;
  state << 0.0, 0.0, 1.0, 0.0, kPi / 2.0;
  const Gaussian<5> turned = Gaussian<5>{state}.moved(constantTurn<2>(1.0, 1.0), 1.0);
  EXPECT_NEAR(turned.mean(0), 2.0 / kPi, 1e-12);
  EXPECT_NEAR(turned.mean(1), 2.0 / kPi, 1e-12);
  EXPECT_NEAR(turned.mean(2), 0.0, 1e-12);
  EXPECT_NEAR(turned.mean(3), 1.0, 1e-12);
}

TEST(MotionModels, SlowTurnIsContinuous) {
  const MotionModel<5> model = constantTurn<2>(1.0, 1.0);
  Eigen::Matrix<double, 5, 1> state;
  state << 0.0, 0.0, 1.0, 0.5, 0.99e-4;
  const Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Identity();
  const Gaussian<5> below = Gaussian<5>{state, covariance}.moved(model, 1.0);
  state(4) = 1.01e-4;
  const Gaussian<5> above = Gaussian<5>{state, covariance}.moved(model, 1.0);
  EXPECT_LT((below.mean - above.mean).norm(), 1e-5);
  EXPECT_LT((below.covariance - above.covariance).norm(), 1e-5);
}

TEST(MotionModels, StandingHasNoVelocity) {
  Eigen::Matrix<double, 4, 1> state(1.0, 2.0, 3.0, 4.0);
  const Gaussian<4> stands = Gaussian<4>{state}.moved(standing<4, 2>(0.1, 0.5), 4.0);
  EXPECT_EQ(stands.mean, (Eigen::Matrix<double, 4, 1>(1.0, 2.0, 0.0, 0.0)));
  EXPECT_NEAR(stands.covariance(0, 0), 0.04, 1e-12);
  EXPECT_NEAR(stands.covariance(2, 2), 0.25, 1e-12);
}

}  // namespace
}  // namespace kestrel
