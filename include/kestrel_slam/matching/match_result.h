// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The estimate of one resolution. The evaluation function compares them.
struct StageEstimate {
  Pose2 pose;
  double score = 0.0;
};

constexpr std::size_t kMatchStages = 3;

/// Result of a matcher.
struct MatchResult {
  Pose2 pose;                                                ///< map_T_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), m² and rad²
  double score = 0.0;  ///< fit of the beams in known space, 0 (no beam) to 1 (all on walls)
  double known = 0.0;  ///< share of the beams in known space, 0 to 1
  int iterations = 0;
  /// Number of other predictions that were tried because the first one did not fit.
  int fallbacks = 0;
  bool converged = false;
  bool searched = false;    ///< the window around the prediction was searched
  bool incomplete = false;  ///< only a part of it, because the work for one scan is limited
  /// Found after a search, but there is a second pose that fits nearly as well.
  bool ambiguous = false;
  bool degenerate = false;  ///< degenerate_direction is unobservable
  /// The weakest direction, as a unit vector in the map frame, or zero.
  Eigen::Vector2d degenerate_direction = Eigen::Vector2d::Zero();
  double degenerate_turn = 0.0;   ///< turn of the vehicle for each meter along it, rad/m
  bool predicted_along = false;   ///< the pose along it is the prediction, corrected by the scan
  bool mostly_predicted = false;  ///< and the prediction is more accurate than the scan
  bool against_inertia = false;   ///< the IMU says that the vehicle is elsewhere
  bool unclear_along = false;     ///< the scan fits nearly as well at the prediction along it
  /// The vehicle cannot have moved to the pose, see MotionCheck: the scan may be matched with
  /// something that moves.
  bool impossible_motion = false;
  /// Variance of the position along it, as far as the scan shows the position, m².
  double along_variance = std::numeric_limits<double>::infinity();
  /// Share of the points that constrain the weakest direction, 0 to 0.5.
  double constraint = 0.0;
  std::array<StageEstimate, kMatchStages> stages;  ///< coarse to fine
};

}  // namespace kestrel
