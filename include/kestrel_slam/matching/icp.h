// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Parameters of the iterative closest point method [Siew 2018; multi-robot ICP].
struct IcpConfig {
  /// point_to_point [Siew 2018, eq. 8; multi-robot ICP, eq. 3] or point_to_line [Siew 2018, eq. 9],
  /// which lets points slide along walls and is more accurate on the recordings.
  std::string metric = "point_to_line";
  /// Reference for the pairs: the points of the map, or the hits of the last_scans. The last scans
  /// ignore the rest of the map when the vehicle returns to a place, so every loop adds drift.
  std::string reference = "map";
  /// Number of inserted scans in this reference. More scans drift less (0.04 m on fr079 with 100)
  /// but cost more; on intel the match slips with 30 and 100, but not with 10.
  int last_scans = 10;
  /// Share of the worst pairs that is rejected. [Siew 2018] rejects 10 %. Here pairs are also
  /// rejected by distance; with 5 % a corridor loses the few pairs that constrain the position
  /// along it.
  double rejected_share = 0.02;
  /// Maximum distance of a pair in the first stage, equal to the reach of the surfels. The other
  /// stages use 40 % and 20 % of it.
  double max_pair_distance_m = 0.5;
  int max_iterations = 30;     ///< maximum iterations of each stage
  double min_step_m = 1e-3;    ///< a stage has converged if a step is smaller than this
  double min_step_rad = 5e-4;  ///< and this; small compared with the errors of a pose
  /// Insert only hits without a nearby point of the map [multi-robot ICP, sec. 3]. Off by default:
  /// a wall that is seen only a few times stays where its first scan placed it.
  bool stitching = false;
};

/// A point of the scan and its partner in the reference.
struct IcpPair {
  Eigen::Vector2f point;    ///< in the base frame, m
  Eigen::Vector2f partner;  ///< in the map frame, m
  Eigen::Vector2f normal;   ///< unit normal of the partner's wall in the map frame; zero if unknown
  /// Squared distance of the metric, m²; the pairs with the largest are rejected.
  float error = 0.0F;
};

/// The pose map_T_base that minimizes Σ |T p - q|² [Siew 2018, eq. 8; multi-robot ICP, eq. 3-5], in
/// closed form: the rotation from the centered points, then the shift of the centroids. What the
/// pairs do not determine is taken from `initial_guess`: the whole pose without pairs, the yaw if
/// the points have no extent.
Pose2 alignPointToPoint(const std::vector<IcpPair>& pairs, const Pose2& initial_guess);

/// The pose map_T_base that minimizes Σ ((T p - q)·n)² [Siew 2018, eq. 9], with damped Gauss-Newton
/// steps from `initial_guess`. A pair without a normal counts with its full distance. Unobservable
/// directions stay at `initial_guess`.
Pose2 alignPointToLine(const std::vector<IcpPair>& pairs, const Pose2& initial_guess);

/// Removes the `share` (0 to 1, rounded down) of the pairs with the largest errors.
void rejectWorstPairs(std::vector<IcpPair>& pairs, double share);

}  // namespace kestrel
