// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {

/// Element of SE(2): a rotation by `yaw` (rad, (-pi, pi]) and a translation (m).
/// `a_T_b` maps coordinates in b to coordinates in a; `a_T_b * b_T_c` is `a_T_c`.
///
/// A tangent vector is (x, y, yaw), m and rad. A small change t of a pose X is on the right,
/// X * exp(t): x and y of t are along the axes of the pose itself (b in `a_T_b`). All Jacobians are
/// derivatives by such changes, of the argument and of the result. `J_c_a` is the derivative of c
/// by a; a null pointer means that it is not wanted.
///
/// [Solà 2018] is Solà, Deray, Atchuthan: A micro Lie theory for state estimation in robotics,
/// arXiv:1812.01537, appendix on SE(2).
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  Pose2() = default;
  Pose2(double x_m, double y_m, double yaw_rad) : x(x_m), y(y_m), yaw(normalizeAngle(yaw_rad)) {}

  Eigen::Vector2d translation() const { return {x, y}; }
  Eigen::Matrix2d rotation() const;
  double distance() const { return std::hypot(x, y); }
  bool isFinite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(yaw); }

  Pose2 inverse() const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {-c * x - s * y, s * x - c * y, -yaw};
  }

  Pose2 operator*(const Pose2& other) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * other.x - s * other.y, y + s * other.x + c * other.y, yaw + other.yaw};
  }

  /// Action on a point.
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return {x + c * p.x() - s * p.y(), y + s * p.x() + c * p.y()};
  }

  /// The pose that a constant velocity `t` reaches from the origin in one unit of time, with its
  /// right Jacobian [Solà 2018, eq. 156, 158, 163]. A turn beyond pi is wrapped.
  static Pose2 exp(const Eigen::Vector3d& t, Eigen::Matrix3d* J_pose_t = nullptr);

  /// The tangent vector t with exp(t) = *this and its yaw in (-pi, pi] [Solà 2018, eq. 157, 158].
  /// It jumps where the yaw wraps.
  Eigen::Vector3d log(Eigen::Matrix3d* J_t_pose = nullptr) const;

  /// exp(t + d) = exp(t) * exp(rightJacobian(t) * d) for small d [Solà 2018, eq. 163].
  static Eigen::Matrix3d rightJacobian(const Eigen::Vector3d& t);
  /// exp(t + d) = exp(leftJacobian(t) * d) * exp(t) for small d [Solà 2018, eq. 164].
  static Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& t);

  /// X * exp(t) = exp(adjoint * t) * X [Solà 2018, eq. 159].
  Eigen::Matrix3d adjoint() const;

  /// [Solà 2018, eq. 154, 160].
  Pose2 inverse(Eigen::Matrix3d* J_inverse_pose) const;
  /// c = *this * b [Solà 2018, eq. 155, 161, 162].
  Pose2 compose(const Pose2& b, Eigen::Matrix3d* J_c_this, Eigen::Matrix3d* J_c_b = nullptr) const;
  /// c = this⁻¹ b: the pose b as seen from this one.
  Pose2 between(const Pose2& b, Eigen::Matrix3d* J_c_this = nullptr,
                Eigen::Matrix3d* J_c_b = nullptr) const;
  /// q = *this * p [Solà 2018, eq. 165, 166, 167].
  Eigen::Vector2d act(const Eigen::Vector2d& p, Eigen::Matrix<double, 2, 3>* J_q_this,
                      Eigen::Matrix2d* J_q_p = nullptr) const;
};

inline bool operator==(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

/// Adds (x, y, yaw) to the components of `pose`: x and y are along the axes of its outer frame (a
/// in `a_T_b`), unlike those of a tangent vector.
inline Pose2 addOffset(const Pose2& pose, const Eigen::Vector3d& offset) {
  return {pose.x + offset.x(), pose.y + offset.y(), pose.yaw + offset.z()};
}

/// `to` - `from`, component by component, the yaw in (-pi, pi]; the inverse of addOffset.
inline Eigen::Vector3d offsetBetween(const Pose2& from, const Pose2& to) {
  return {to.x - from.x, to.y - from.y, normalizeAngle(to.yaw - from.yaw)};
}

/// `a` where `share` is 0, `b` where it is 1. Between them the position moves on a straight line
/// and the yaw turns evenly, the shorter way.
inline Pose2 interpolate(const Pose2& a, const Pose2& b, double share) {
  const double rest = 1.0 - share;
  return {rest * a.x + share * b.x, rest * a.y + share * b.y,
          a.yaw + share * normalizeAngle(b.yaw - a.yaw)};
}

}  // namespace kestrel
