// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Indices, in order and at most `max_points` of them (from 4), that draw the same curve as all of
/// `values`: the first, the last, and the smallest and largest of equal stretches in between.
std::vector<std::size_t> minMaxIndices(const std::vector<double>& values, std::size_t max_points);

/// Speed along the path and turn rate at every pose.
struct Speeds {
  std::vector<double> linear_m_s;
  std::vector<double> angular_rad_s;
};

/// Measured over at least half a second back in time, so that the noise of single poses does not
/// hide the motion. `times` (s) must not decrease.
Speeds speedsOf(const std::vector<double>& times, const std::vector<Pose2>& poses);

}  // namespace kestrel
