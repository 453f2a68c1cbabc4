// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// How well a scan fits a map at a pose.
struct Fit {
  /// Mean of 1 / (1 + d² / scale²) over the points in known space; d: distance to the wall. Points
  /// in unknown space are ignored. If they counted as misses, no scan could be inserted at a door.
  double score = 0.0;
  double known = 0.0;    ///< share of the points in known space
  double on_wall = 0.0;  ///< share of the points within `scale_m` of a wall
  /// Mean of n n' over the points on walls; n: normal of the wall. The smaller eigenvalue shows how
  /// well the weakest direction is constrained: 0 not at all, 0.5 as well as the other.
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  double residual_variance = 0.0;  ///< robust variance of the distances, m²
};

/// Constraint of the weakest direction: the smaller eigenvalue of `fit.normals` minus the part that
/// is due to kAlongWeight.
double leastConstraint(const Fit& fit);

/// Fit of `points` (base frame, m) at a pose. `scale_m`: distance at which a point fits by half.
Fit fitOf(const Submap& map, const Points& points, const Pose2& map_T_base, double scale_m);

}  // namespace kestrel
