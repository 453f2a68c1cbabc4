// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {

/// Element of SE(2): a rotation by `yaw` (rad, (-pi, pi]) and a translation (m).
/// `a_T_b` maps coordinates in b to coordinates in a; `a_T_b * b_T_c` is `a_T_c`.
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  Pose2() = default;
  Pose2(double x_m, double y_m, double yaw_rad) : x(x_m), y(y_m), yaw(normalizeAngle(yaw_rad)) {}

  Eigen::Vector2d translation() const { return {x, y}; }
  double distance() const { return std::hypot(x, y); }

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

  bool isFinite() const { return std::isfinite(x) && std::isfinite(y) && std::isfinite(yaw); }
};

inline bool operator==(const Pose2& a, const Pose2& b) {
  return a.x == b.x && a.y == b.y && a.yaw == b.yaw;
}

}  // namespace kestrel
