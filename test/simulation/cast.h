// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>

#include "kestrel_slam/simulation/world.h"

namespace kestrel {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFar = 1e6;  // m

/// From `origin` to the first surface, m.
inline double distance(const World& world, const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& direction, double time = 0.0) {
  return world.cast(origin, direction, time, kFar).distance;
}

}  // namespace kestrel
