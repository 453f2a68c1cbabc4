// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// The window of a search around a center pose.
struct SearchWindow {
  double linear_m = 0.6;     ///< ± in x and y
  double angular_rad = 0.5;  ///< ±
};

/// Parameters of the exhaustive search.
struct CorrelativeConfig {
  double sigma_m = 0.1;  ///< standard deviation of the likelihood over the distance to a wall
  double min_angular_step_rad = 0.0044;
  double linear_preference = 0.05;   ///< penalty per meter of motion, in units of the score
  double angular_preference = 0.02;  ///< penalty per radian of motion
};

/// Result of a search.
struct SearchResult {
  Pose2 pose;          ///< the grid pose with the maximum penalized score
  Pose2 mean;          ///< mean of the likelihood surface around it; more accurate than the grid
  double score = 0.0;  ///< mean likelihood of the points, 0 to 1
  double penalized_score = 0.0;  ///< the score minus the penalty of the motion; this is maximized
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of the likelihood surface around
                                                             ///< `pose`; (x, y, yaw), m² and rad²
};

/// Poses that a search must not find: those near `pose`, in position and in yaw.
struct ExcludedPoses {
  Pose2 pose;
  double linear_m = 0.0;     ///< ± in x and y
  double angular_rad = 0.0;  ///< ±
  /// Unit vector in the map frame along which the distance does not count, or zero.
  Eigen::Vector2d ignored_direction = Eigen::Vector2d::Zero();
};

/// Whether `pose` is one of the excluded poses.
bool isNear(const ExcludedPoses& excluded, const Pose2& pose);

/// Exhaustive search of a window in steps of one cell and one angular step. Branch and bound on a
/// pyramid of maxima [MAV SLAM 2013, eq. 3; Olson 2009]; the result is exact. Poses are in the map
/// frame, `points` are in the base frame, m. Without points the result is the center.
SearchResult searchWindow(const SurfelField& surface, const Points& points, const Pose2& center,
                          const SearchWindow& window, const CorrelativeConfig& config);

/// The same as the first without branch and bound, for tests.
SearchResult searchWindowBruteForce(const SurfelField& surface, const Points& points,
                                    const Pose2& center, const SearchWindow& window,
                                    const CorrelativeConfig& config);

}  // namespace kestrel
