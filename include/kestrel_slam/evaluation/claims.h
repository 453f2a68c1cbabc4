// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/evaluation/evaluation.h"
#include "kestrel_slam/mapping/pose_uncertainty.h"

namespace kestrel {

/// The claimed uncertainty of the pose of one scan.
struct Claim {
  double stamp = 0.0;
  UncertainPose pose;
};

/// One line for each: the stamp, x, y, yaw of the pose (m, rad), and of the shared and of the own
/// covariance the elements xx xy xt yy yt tt (UncertainPose). Both throw std::runtime_error that
/// names the file (and the line) and what is wrong.
void writeClaims(const std::string& path, const std::vector<Claim>& claims);
std::vector<Claim> readClaims(const std::string& path);

/// Errors of relations in units of what was claimed for them (relativeCovariance).
struct ClaimEvaluation {
  ErrorStatistics translation;  ///< error over the standard deviation of the translation
  ErrorStatistics rotation;     ///< error over the standard deviation of the rotation
  ErrorStatistics nees;         ///< 3 is right in the mean
};

/// Relations with an end that has no claim are left out.
ClaimEvaluation evaluateClaims(const std::vector<Claim>& claims,
                               const std::vector<Relation>& relations);

}  // namespace kestrel
