// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_models.h"

#include <cmath>

namespace kestrel {
namespace {

// Below this angle (rad) of one step, the turn is replaced by its series.
constexpr double kSmallTurn = 1e-4;

/// Q of an acceleration that is constant during the step.
template <int N, int D>
void addAccelerationNoise(double sigma, double seconds, Eigen::Matrix<double, N, N>& noise) {
  const double variance = sigma * sigma, t2 = seconds * seconds;
  for (int i = 0; i < D; ++i) {
    noise(i, i) += variance * t2 * t2 / 4.0;
    noise(i, D + i) += variance * t2 * seconds / 2.0;
    noise(D + i, i) += variance * t2 * seconds / 2.0;
    noise(D + i, D + i) += variance * t2;
  }
}

template <int N, int D>
void setTurnNoise(double sigma, Eigen::Matrix<double, N, N>& noise) {
  if constexpr (N > 2 * D) noise(N - 1, N - 1) = sigma * sigma;
}

/// sin(a) / w, (1 - cos(a)) / w for a = w t, and their derivatives by w.
struct TurnTerms {
  double s, c, ds, dc;
};

TurnTerms turnTerms(double rate, double t) {
  const double angle = rate * t;
  if (std::abs(angle) < kSmallTurn) {
    return {t, angle * t / 2.0, -angle * t * t / 3.0, t * t / 2.0};
  }
  const double s = std::sin(angle) / rate, c = (1.0 - std::cos(angle)) / rate;
  return {s, c, (t * std::cos(angle) - s) / rate, (t * std::sin(angle) - c) / rate};
}

}  // namespace

template <int N, int D>
MotionModel<N> standing(double position_sigma, double velocity_sigma) {
  return [=](const Eigen::Matrix<double, N, 1>& state, double seconds) {
    Transition<N> result;
    result.mean.setZero();
    result.mean.template head<D>() = state.template head<D>();
    result.jacobian.setZero();
    result.jacobian.template topLeftCorner<D, D>().setIdentity();
    result.noise.setZero();
    const double moved = position_sigma * position_sigma * seconds;
    result.noise.diagonal().template head<D>().setConstant(moved);
    const double variance = velocity_sigma * velocity_sigma;
    result.noise.diagonal().template segment<D>(D).setConstant(variance);
    return result;
  };
}

template <int N, int D>
MotionModel<N> constantVelocity(double acceleration_sigma, double turn_sigma) {
  return [=](const Eigen::Matrix<double, N, 1>& state, double seconds) {
    Transition<N> result;
    result.jacobian.setZero();
    result.jacobian.template topLeftCorner<2 * D, 2 * D>().setIdentity();
    result.jacobian.template block<D, D>(0, D).diagonal().setConstant(seconds);
    result.mean = result.jacobian * state;
    result.noise.setZero();
    addAccelerationNoise<N, D>(acceleration_sigma, seconds, result.noise);
    setTurnNoise<N, D>(turn_sigma, result.noise);
    return result;
  };
}

template <int D>
MotionModel<2 * D + 1> constantTurn(double acceleration_sigma, double turn_acceleration_sigma) {
  constexpr int N = 2 * D + 1;
  return [=](const Eigen::Matrix<double, N, 1>& state, double t) {
    const double rate = state(N - 1), vx = state(D), vy = state(D + 1);
    const double sine = std::sin(rate * t), cosine = std::cos(rate * t);
    const TurnTerms terms = turnTerms(rate, t);
    Transition<N> result;
    result.jacobian.setIdentity();
    result.jacobian.template block<D, D>(0, D).diagonal().setConstant(t);
    result.jacobian.template block<2, 2>(0, D) << terms.s, -terms.c, terms.c, terms.s;
    result.jacobian.template block<2, 2>(D, D) << cosine, -sine, sine, cosine;
    result.mean = result.jacobian * state;
    // The model is linear but for the turn rate: its column is added after the mean is known.
    result.jacobian.template block<2, 1>(0, N - 1) << terms.ds * vx - terms.dc * vy,
        terms.dc * vx + terms.ds * vy;
    result.jacobian.template block<2, 1>(D, N - 1) << t * (-sine * vx - cosine * vy),
        t * (cosine * vx - sine * vy);
    result.noise.setZero();
    addAccelerationNoise<N, D>(acceleration_sigma, t, result.noise);
    setTurnNoise<N, D>(turn_acceleration_sigma * t, result.noise);
    return result;
  };
}

template MotionModel<4> standing<4, 2>(double, double);
template MotionModel<5> standing<5, 2>(double, double);
template MotionModel<7> standing<7, 3>(double, double);
template MotionModel<4> constantVelocity<4, 2>(double, double);
template MotionModel<5> constantVelocity<5, 2>(double, double);
template MotionModel<7> constantVelocity<7, 3>(double, double);
template MotionModel<5> constantTurn<2>(double, double);
template MotionModel<7> constantTurn<3>(double, double);

}  // namespace kestrel
