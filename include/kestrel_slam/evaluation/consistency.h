// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "kestrel_slam/mapping/pose_uncertainty.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Normalized estimation error squared (NEES): e' C⁻¹ e of an error e in (x, y, yaw) with
/// covariance C (m, rad). If C is correct, the mean is 3, and 95 % of the values lie within
/// kNeesBand (chi-square distribution with 3 degrees of freedom).
double neesOf(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance);
constexpr std::pair<double, double> kNeesBand = {0.2158, 9.3484};

/// The 95 % band of the mean of `count` independent chi-square values with `freedom` degrees of
/// freedom each (approximation by Wilson and Hilferty).
std::pair<double, double> meanNeesBand(std::size_t count, double freedom = 3.0);

/// An estimated and a true pose, both in map. The first true pose defines the origin of map.
struct EvaluatedPose {
  double stamp = 0.0;  ///< s
  UncertainPose estimate;
  Pose2 truth;
};

/// The errors of one run, compared with the estimated covariances. Errors of neighboring scans are
/// strongly correlated, so only one pose per second is used, and motions do not overlap.
struct Consistency {
  std::vector<double> absolute;  ///< NEES of the pose, one per second, beginning after one second
  std::vector<double> relative;  ///< NEES of the motion over each interval of one second
  /// Largest position errors of all scans, along the axes of the covariance ellipse of each scan:
  /// along the long axis in m and in standard deviations, and along the short axis in m.
  double worst_long_m = 0.0, worst_long_sigmas = 0.0, worst_short_m = 0.0;
};

/// `poses` must be in the order of their stamps.
Consistency consistencyOf(const std::vector<EvaluatedPose>& poses);

/// The mean; 0 if there are no values.
double meanOf(const std::vector<double>& values);
/// Fraction of the values within a band, 0 to 1; 0 if there are no values.
double shareWithin(const std::vector<double>& values, const std::pair<double, double>& band);

}  // namespace kestrel
