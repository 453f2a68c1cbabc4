// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// What to search, around a center.
struct SearchWindow {
  double linear_m = 0.6;     ///< ± in x and y
  double angular_rad = 0.5;  ///< ±
};

/// Parameters of the exhaustive search.
struct CorrelativeConfig {
  double sigma_m = 0.1;  ///< of the likelihood of a distance to a wall
  double min_angular_step_rad = 0.0044;
  double linear_preference = 0.05;   ///< what a meter of motion costs, in units of the score
  double angular_preference = 0.02;  ///< what a radian costs
};

/// The best pose of a window.
struct SearchResult {
  Pose2 pose;                    ///< the cell and angular step of the maximum
  Pose2 mean;                    ///< mean of the likelihood surface around it: finer than a cell
  double score = 0.0;            ///< mean likelihood of the points, 0 to 1
  double penalized_score = 0.0;  ///< the score less the cost of the motion: what was maximized
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Identity();  ///< of the likelihood surface around it
};

/// Exhaustive search of a window in steps of one cell and one angular step, exact: branch and bound
/// on the pyramid of maxima (paper 000 eq. 3; E. Olson, "Real-time correlative scan matching",
/// ICRA 2009).
SearchResult searchWindow(const SurfelField& surface, const Points& points, const Pose2& center,
                          const SearchWindow& window, const CorrelativeConfig& config);

/// The same maximum without bounds, for tests.
SearchResult searchWindowBruteForce(const SurfelField& surface, const Points& points,
                                    const Pose2& center, const SearchWindow& window,
                                    const CorrelativeConfig& config);

}  // namespace kestrel
