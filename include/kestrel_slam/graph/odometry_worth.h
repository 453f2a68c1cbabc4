// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/odometry_chain.h"

namespace kestrel {

/// How good an odometry is. Its poses have errors that do not grow (they were measured at another
/// time than the scan), and errors that grow with the distance.
struct OdometryWorth {
  double scale = 1.0;            ///< of the distance
  double yaw_per_m = 0.0;        ///< added to the yaw for each meter
  double yaw_per_rad = 0.0;      ///< added to the yaw for each rad that was measured
  double position_m2 = 0.0;      ///< variance of each pose, along x and along y; 0: not known yet
  double yaw_rad2 = 0.0;         ///< variance of each yaw
  double position_growth = 0.0;  ///< variance along x and along y for each meter, m²/m
  double yaw_growth = 0.0;       ///< variance of the yaw for each meter, rad²/m

  bool isCorrected() const { return scale != 1.0 || yaw_per_m != 0.0 || yaw_per_rad != 0.0; }
};

/// A pose by the odometry and the pose of the same keyframe by matching.
struct OdometryPoint {
  std::size_t keyframe = 0;
  Pose2 matched, measured;
};

/// Length of a motion, m. A turn counts too.
double lengthOf(const Pose2& motion);

/// What the odometry is worth, by comparing it with the matches over distances of all sizes: what
/// the covariance of the matches does not explain is its error. `chain`: the matches.
OdometryWorth worthOf(std::vector<OdometryPoint> points, const OdometryChain& chain);

/// Takes the systematic errors away.
void correct(const OdometryWorth& worth, std::vector<OdometryPoint>& points);

/// Variances (x, y, yaw) of the error of the corrected odometry over a motion, with those of the
/// poses at both ends.
Eigen::Vector3d varianceOf(const OdometryWorth& worth, const Pose2& motion);

/// Whether 99 % of the errors with this covariance are smaller.
bool isExpected(const Pose2& error, const Eigen::Matrix3d& covariance);

/// How much the single steps of the odometry differ from the matches: a number to compare with
/// others, small if they agree.
double stepDifference(const std::vector<OdometryPoint>& points, const OdometryChain& chain);

}  // namespace kestrel
