// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/pose2.h"

#include <cmath>

namespace kestrel {
namespace {

/// sin(angle) / angle.
double sinc(double angle) { return angle == 0.0 ? 1.0 : std::sin(angle) / angle; }

/// (1 - cos(angle)) / angle, without the cancellation of a small angle.
double versine(double angle) { return std::sin(0.5 * angle) * sinc(0.5 * angle); }

/// (angle - sin(angle)) / angle².
double sineDefect(double angle) {
  constexpr double kSeriesBelow = 0.1;  // there the first term left out is below 1e-16
  const double square = angle * angle;
  if (std::abs(angle) > kSeriesBelow) return (angle - std::sin(angle)) / square;
  return angle / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)));
}

/// angle / tan(angle).
double cotangent(double angle) { return angle == 0.0 ? 1.0 : angle / std::tan(angle); }

/// A scaled rotation: [c -s; s c].
Eigen::Matrix2d similarity(double c, double s) {
  Eigen::Matrix2d result;
  result << c, -s, s, c;
  return result;
}

Eigen::Matrix3d withLastColumn(const Eigen::Matrix2d& rotation, const Eigen::Vector2d& column) {
  Eigen::Matrix3d result = Eigen::Matrix3d::Identity();
  result.topLeftCorner<2, 2>() = rotation;
  result.topRightCorner<2, 1>() = column;
  return result;
}

/// What a turn by one radian does to `v`, to first order.
Eigen::Vector2d quarterTurned(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// V(angle) of [Solà 2018, eq. 158] and its inverse.
Eigen::Matrix2d chordOf(double angle) { return similarity(sinc(angle), versine(angle)); }
Eigen::Matrix2d inverseChordOf(double angle) {
  return similarity(cotangent(0.5 * angle), -0.5 * angle);
}

/// The last column of the right Jacobian.
Eigen::Vector2d turnColumn(const Eigen::Vector3d& t) {
  const double half = 0.5 * sinc(0.5 * t.z()) * sinc(0.5 * t.z());  // (1 - cos) / angle²
  return similarity(sineDefect(t.z()), half) * t.head<2>();
}

}  // namespace

Eigen::Matrix2d Pose2::rotation() const { return similarity(std::cos(yaw), std::sin(yaw)); }

Pose2 Pose2::exp(const Eigen::Vector3d& t, Eigen::Matrix3d* J_pose_t) {
  if (J_pose_t != nullptr) *J_pose_t = rightJacobian(t);
  const Eigen::Vector2d position = chordOf(t.z()) * t.head<2>();
  return {position.x(), position.y(), t.z()};
}

Eigen::Vector3d Pose2::log(Eigen::Matrix3d* J_t_pose) const {
  Eigen::Vector3d t;
  t << inverseChordOf(yaw) * translation(), yaw;
  if (J_t_pose != nullptr) {  // the inverse of the right Jacobian, block by block
    const Eigen::Matrix2d inverse = inverseChordOf(-yaw);
    *J_t_pose = withLastColumn(inverse, -inverse * turnColumn(t));
  }
  return t;
}

Eigen::Matrix3d Pose2::rightJacobian(const Eigen::Vector3d& t) {
  return withLastColumn(chordOf(-t.z()), turnColumn(t));
}

Eigen::Matrix3d Pose2::leftJacobian(const Eigen::Vector3d& t) { return rightJacobian(-t); }

Eigen::Matrix3d Pose2::adjoint() const {
  return withLastColumn(rotation(), -quarterTurned(translation()));
}

Pose2 Pose2::inverse(Eigen::Matrix3d* J_inverse_pose) const {
  if (J_inverse_pose != nullptr) *J_inverse_pose = -adjoint();
  return inverse();
}

Pose2 Pose2::compose(const Pose2& b, Eigen::Matrix3d* J_c_this, Eigen::Matrix3d* J_c_b) const {
  if (J_c_this != nullptr) *J_c_this = b.inverse().adjoint();
  if (J_c_b != nullptr) J_c_b->setIdentity();
  return *this * b;
}

Pose2 Pose2::between(const Pose2& b, Eigen::Matrix3d* J_c_this, Eigen::Matrix3d* J_c_b) const {
  const Pose2 c = inverse() * b;
  if (J_c_this != nullptr) *J_c_this = -c.inverse().adjoint();
  if (J_c_b != nullptr) J_c_b->setIdentity();
  return c;
}

Eigen::Vector2d Pose2::act(const Eigen::Vector2d& p, Eigen::Matrix<double, 2, 3>* J_q_this,
                           Eigen::Matrix2d* J_q_p) const {
  const Eigen::Matrix2d r = rotation();
  if (J_q_this != nullptr) *J_q_this << r, r * quarterTurned(p);
  if (J_q_p != nullptr) *J_q_p = r;
  return *this * p;
}

}  // namespace kestrel
