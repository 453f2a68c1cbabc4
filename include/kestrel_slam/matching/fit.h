// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// How well a scan fits a map at a pose.
struct Fit {
  /// Mean over the points in known space of 1 / (1 + d² / scale²), d the distance to the wall.
  /// Points in unknown space say nothing: counted as misses they would starve the map at doors.
  double score = 0.0;
  double known = 0.0;    ///< share of the points that end in known space
  double on_wall = 0.0;  ///< share of the points that end within `scale_m` of a wall
  /// Mean of n n' over the fitting points, n the normal of their wall: its smaller eigenvalue says
  /// how well the less constrained direction is seen (0: not at all, 0.5: as well as the other).
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  double residual_variance = 0.0;  ///< robust variance of the distances, m²
};

/// How well the less constrained direction is seen beyond what walls count along themselves: the
/// smaller eigenvalue of `fit.normals` less that.
double leastConstraint(const Fit& fit);

Fit fitOf(const Submap& map, const Points& points, const Pose2& map_T_base, double scale_m);

}  // namespace kestrel
