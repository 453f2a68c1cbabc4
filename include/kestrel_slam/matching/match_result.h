// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The estimate of one resolution, coarse to fine: what the evaluation function compares.
struct StageEstimate {
  Pose2 pose;
  double score = 0.0;
};

constexpr std::size_t kMatchStages = 3;

/// What every matcher returns.
struct MatchResult {
  Pose2 pose;                                                ///< map_T_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), m² and rad²
  double score = 0.0;  ///< fit of the beams that end in known space, 0 (none) to 1 (all on walls)
  double known = 0.0;  ///< share of the beams that end in known space, 0 to 1
  int iterations = 0;
  int fallbacks = 0;  ///< predictions that were tried beside the first, as that fitted badly
  bool converged = false;
  bool searched = false;    ///< the exhaustive search ran
  bool degenerate = false;  ///< the scan does not constrain the direction below
  Eigen::Vector2d degenerate_direction = Eigen::Vector2d::Zero();  ///< unit vector in map, or zero
  double constraint = 0.0;  ///< share of the points that constrain the weakest direction, 0 to 0.5
  std::array<StageEstimate, kMatchStages> stages;  ///< coarse to fine
};

}  // namespace kestrel
