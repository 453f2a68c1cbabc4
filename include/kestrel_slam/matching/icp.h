// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Parameters of the iterative closest point method (papers 003 and 004).
struct IcpConfig {
  /// point_to_point (paper 003 eq. 8, paper 004 eq. 3) or point_to_line (paper 003 eq. 9): the
  /// latter slides along walls, and is the more accurate on the recordings.
  std::string metric = "point_to_line";
  /// What a scan is paired with: the points of the map, or the hits of the last_scans, which know
  /// nothing of the map when the vehicle comes back, so that every loop adds its drift.
  std::string reference = "map";
  /// So many inserted scans are that reference. More of them drift less, up to 0.04 m on fr079 with
  /// 100, but cost more; on intel 30 and 100 slip where 10 do not.
  int last_scans = 10;
  /// Worst pairs that do not count. Paper 003 takes 10 %; here the distance of the partners rejects
  /// as well, and with 5 % a corridor loses the few pairs that say how far along it the vehicle is.
  double rejected_share = 0.02;
  /// Of the first stage, as far as surfels reach; the others take 40 % and 20 % of it.
  double max_pair_distance_m = 0.5;
  int max_iterations = 30;     ///< pairings of each stage
  double min_step_m = 1e-3;    ///< a stage has converged when a step is smaller than this,
  double min_step_rad = 5e-4;  ///< and this: small against the errors of a pose
  /// Only hits without a point of the map beside them enter it (paper 004). Off: a wall that is not
  /// seen again and again stays where its first scan put it.
  bool stitching = false;
};

/// A point of the scan and the point of the reference that is its partner.
struct IcpPair {
  Eigen::Vector2f point;    ///< in base, m
  Eigen::Vector2f partner;  ///< in map, m
  Eigen::Vector2f normal;   ///< of the partner's wall, unit vector in map; zero where unknown
  float error = 0.0F;       ///< of the metric, m²: what rejection compares
};

/// The pose map_T_base that minimizes Σ |T p - q|² (paper 003 eq. 8, paper 004 eq. 3-5), in closed
/// form: the turn of the centerd points, then the shift of the centroids. Keeps of `initial_guess`
/// what the pairs leave open: all of it without pairs, the yaw where the points have no extent.
Pose2 alignPointToPoint(const std::vector<IcpPair>& pairs, const Pose2& initial_guess);

/// The pose map_T_base that minimizes Σ ((T p - q)·n)² (paper 003 eq. 9) by damped Gauss-Newton
/// steps from `initial_guess`. A pair without a normal counts with its whole distance. Directions
/// of which the pairs say nothing stay as at `initial_guess`.
Pose2 alignPointToLine(const std::vector<IcpPair>& pairs, const Pose2& initial_guess);

/// Removes the `share` of the pairs, rounded down, whose errors are largest.
void rejectWorstPairs(std::vector<IcpPair>& pairs, double share);

}  // namespace kestrel
