// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

namespace kestrel {

/// A motion model: moves a Gaussian on by `seconds` [Siew 2018, eq. 19]. The covariance P becomes
/// F P F' + Q. For a model that is not linear, F is the Jacobian at the mean (extended Kalman
/// filter).
template <int N>
using MotionModel = std::function<void(double seconds, Eigen::Matrix<double, N, 1>& mean,
                                       Eigen::Matrix<double, N, N>& covariance)>;

/// The models below are for states that begin with a position and a velocity in D dimensions. A
/// state with one more component has the turn rate (rad/s, about z) there: N is 2 D or 2 D + 1.

/// Stands: the velocity is zero. `position_sigma`: how far the measured middle of the object moves
/// in a second while it stands, m. `velocity_sigma`: its velocity when it starts, m/s.
template <int N, int D>
MotionModel<N> standing(double position_sigma, double velocity_sigma);

/// Moves straight on. `acceleration_sigma` (m/s²): the acceleration, constant during a step and
/// independent of other steps [Vo 2006, sec. IV]. The turn rate is zero; `turn_sigma` is its
/// standard deviation when a turn starts, rad/s.
template <int N, int D>
MotionModel<N> constantVelocity(double acceleration_sigma, double turn_sigma = 0.0);

/// Turns about z with the turn rate of the state [Vo 2006, sec. IV-C]. `acceleration_sigma` as
/// above, `turn_acceleration_sigma` in rad/s².
template <int D>
MotionModel<2 * D + 1> constantTurn(double acceleration_sigma, double turn_acceleration_sigma);

}  // namespace kestrel
