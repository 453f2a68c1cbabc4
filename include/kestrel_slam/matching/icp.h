#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel_slam {

/// Parameters of the iterative closest point method (papers 003 and 004).
struct IcpConfig {
  std::string metric = "point_to_line";  ///< or point_to_point (paper 003 eq. 9 and 8)
  std::string reference = "map";         ///< what a scan is paired with; or last_scans
  int last_scans = 10;                   ///< so many inserted scans are that reference
  double rejected_share = 0.02;
  double max_pair_distance_m = 0.5;      ///< of the first stage; the later ones look less far
  int max_iterations = 30;               ///< pairings of each stage
  double min_step_m = 1e-3;    ///< a stage has converged when a step is smaller than this,
  double min_step_rad = 5e-4;  ///< and this
  bool stitching =
      false;  ///< only hits without a point of the map beside them enter it (paper 004)
};

/// A point of the scan and the point of the reference that is its partner.
struct IcpPair {
  Eigen::Vector2f point;    ///< in base, m
  Eigen::Vector2f partner;  ///< in map, m
  Eigen::Vector2f normal;   ///< of the partner's wall, unit vector in map; zero where unknown
  float error = 0.0F;       ///< of the metric, m²: what rejection compares
};

/// The pose map_T_base that minimises Σ |T p - q|² (paper 003 eq. 8, paper 004 eq. 3-5), in closed
/// form: the turn of the centred points, then the shift of the centroids. Keeps of `start` what the
/// pairs leave open: all of it without pairs, the heading where the points have no extent.
Pose2 alignPointToPoint(const std::vector<IcpPair>& pairs, const Pose2& start);

/// The pose map_T_base that minimises Σ ((T p - q)·n)² (paper 003 eq. 9) by damped Gauss-Newton
/// steps from `start`. A pair without a normal counts with its whole distance. Directions of which
/// the pairs say nothing stay as at `start`.
Pose2 alignPointToLine(const std::vector<IcpPair>& pairs, const Pose2& start);

/// Removes the `share` of the pairs, rounded down, whose errors are largest.
void rejectWorstPairs(std::vector<IcpPair>& pairs, double share);

}  // namespace kestrel_slam
