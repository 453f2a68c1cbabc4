// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/motion_models.h"

#include <cmath>

namespace kestrel {
namespace {

// Below this angle (rad) of one step, the turn is replaced by its series.
constexpr double kSmallTurn = 1e-4;

/// Adds Q of an acceleration that is constant during the step.
template <int N, int D>
void addAccelerationNoise(double sigma, double seconds, Eigen::Matrix<double, N, N>& covariance) {
  const double variance = sigma * sigma, t2 = seconds * seconds;
  for (int i = 0; i < D; ++i) {
    covariance(i, i) += variance * t2 * t2 / 4.0;
    covariance(i, D + i) += variance * t2 * seconds / 2.0;
    covariance(D + i, i) += variance * t2 * seconds / 2.0;
    covariance(D + i, D + i) += variance * t2;
  }
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
  return [=](double seconds, Eigen::Matrix<double, N, 1>& mean,
             Eigen::Matrix<double, N, N>& covariance) {
    mean.template tail<N - D>().setZero();
    covariance.template rightCols<N - D>().setZero();
    covariance.template bottomLeftCorner<N - D, D>().setZero();
    auto variances = covariance.diagonal();
    variances.template head<D>().array() += position_sigma * position_sigma * seconds;
    variances.template segment<D>(D).setConstant(velocity_sigma * velocity_sigma);
  };
}

template <int N, int D>
MotionModel<N> constantVelocity(double acceleration_sigma, double turn_sigma) {
  return [=](double seconds, Eigen::Matrix<double, N, 1>& mean,
             Eigen::Matrix<double, N, N>& covariance) {
    mean.template head<D>() += seconds * mean.template segment<D>(D);
    covariance.template topRows<D>() += seconds * covariance.template middleRows<D>(D);
    covariance.template leftCols<D>() += seconds * covariance.template middleCols<D>(D);
    if constexpr (N > 2 * D) {
      mean(N - 1) = 0.0;
      covariance.row(N - 1).setZero();
      covariance.col(N - 1).setZero();
      covariance(N - 1, N - 1) = turn_sigma * turn_sigma;
    }
    addAccelerationNoise<N, D>(acceleration_sigma, seconds, covariance);
  };
}

template <int D>
MotionModel<2 * D + 1> constantTurn(double acceleration_sigma, double turn_acceleration_sigma) {
  constexpr int N = 2 * D + 1;
  return [=](double t, Eigen::Matrix<double, N, 1>& mean, Eigen::Matrix<double, N, N>& covariance) {
    const double rate = mean(N - 1), vx = mean(D), vy = mean(D + 1);
    const double sine = std::sin(rate * t), cosine = std::cos(rate * t);
    const TurnTerms terms = turnTerms(rate, t);
    // What velocity and turn rate add to the position, and the velocity that they become.
    Eigen::Matrix<double, D, D + 1> way, turned;
    way.setZero();
    way.diagonal().setConstant(t);
    way.template topLeftCorner<2, 2>() << terms.s, -terms.c, terms.c, terms.s;
    turned.setIdentity();
    turned.template topLeftCorner<2, 2>() << cosine, -sine, sine, cosine;
    const Eigen::Matrix<double, D, 1> velocity = mean.template segment<D>(D);
    mean.template head<D>() += way.template leftCols<D>() * velocity;
    mean.template segment<D>(D) = turned.template leftCols<D>() * velocity;
    // The model is linear but for the turn rate.
    way.template topRightCorner<2, 1>() << terms.ds * vx - terms.dc * vy,
        terms.dc * vx + terms.ds * vy;
    turned.template topRightCorner<2, 1>() << t * (-sine * vx - cosine * vy),
        t * (cosine * vx - sine * vy);
    const Eigen::Matrix<double, D + 1, N> rows = covariance.template bottomRows<D + 1>();
    covariance.template topRows<D>() += way.lazyProduct(rows);
    covariance.template middleRows<D>(D) = turned.lazyProduct(rows);
    const Eigen::Matrix<double, N, D + 1> columns = covariance.template rightCols<D + 1>();
    covariance.template leftCols<D>() += columns.lazyProduct(way.transpose());
    covariance.template middleCols<D>(D) = columns.lazyProduct(turned.transpose());
    covariance(N - 1, N - 1) += turn_acceleration_sigma * t * turn_acceleration_sigma * t;
    addAccelerationNoise<N, D>(acceleration_sigma, t, covariance);
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
