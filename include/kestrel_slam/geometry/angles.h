// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

namespace kestrel {

constexpr double kPi = 3.14159265358979323846;

/// Wraps an angle in radians to (-pi, pi].
inline double normalizeAngle(double angle) {
  if (angle > -kPi && angle <= kPi) return angle;
  const double wrapped = std::remainder(angle, 2.0 * kPi);  // in [-pi, pi]
  return wrapped <= -kPi ? kPi : wrapped;
}

inline constexpr double degToRad(double deg) { return deg * kPi / 180.0; }
inline constexpr double radToDeg(double rad) { return rad * 180.0 / kPi; }

}  // namespace kestrel
