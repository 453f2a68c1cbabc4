// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Normalized estimation error squared e' C⁻¹ e of an error in (x, y, yaw): where C is the true
/// covariance it has the mean 3 and lies within kNeesBand in 95 of 100 cases (chi-square, 3 degrees
/// of freedom).
double neesOf(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);
constexpr std::pair<double, double> kNeesBand = {0.2158, 9.3484};

/// The 95 % band of the mean of `count` independent values with so many degrees of freedom each
/// (Wilson and Hilferty's approximation).
std::pair<double, double> meanNeesBand(std::size_t count, double freedom = 3.0);

/// A pose with its truth, both of them in map: the true motion is counted from the first pose,
/// which defines the map.
struct JudgedPose {
  double stamp = 0.0;
  UncertainPose found;
  Pose2 truth;
};

/// How the errors of one run compare with what was claimed. Errors of neighboring scans are nearly
/// the same, so only one pose a second counts, and only motions that do not overlap.
struct Consistency {
  std::vector<double> absolute;  ///< NEES of the pose, one a second from the first second on
  std::vector<double> relative;  ///< NEES of the motion over each second
  /// Of the pose, over all scans, in the axes of its ellipse at that scan: largest error along the
  /// long axis, m, that in claimed standard deviations, and the largest along the short axis, m.
  double worst_long_m = 0.0, worst_long_sigmas = 0.0, worst_short_m = 0.0;
};

Consistency consistencyOf(const std::vector<JudgedPose>& poses);

double meanOf(const std::vector<double>& values);
/// Share of the values within a band, 0 to 1.
double shareWithin(const std::vector<double>& values, const std::pair<double, double>& band);

}  // namespace kestrel
