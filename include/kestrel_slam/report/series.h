// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Selects at most `max_points` (at least 4) values so that a plot looks like the plot of all
/// `values`: the first, the last, and the minimum and maximum of each of several equal intervals.
/// Returns their indices in ascending order.
std::vector<std::size_t> minMaxIndices(const std::vector<double>& values, std::size_t max_points);

/// Speed (m/s) and yaw rate (rad/s) at every pose.
struct Speeds {
  std::vector<double> linear_m_s;
  std::vector<double> angular_rad_s;
};

/// Computes speeds from the motion over the last half second or more, which reduces the noise of
/// single poses. `times` (s) must not decrease.
Speeds speedsOf(const std::vector<double>& times, const std::vector<Pose2>& poses);

}  // namespace kestrel
