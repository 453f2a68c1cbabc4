// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// The result of matching one scan, for the pose filter and the projector.
struct MatchedPose {
  double stamp = 0.0;                                    ///< of the scan, s
  Pose2 pose;                                            ///< map_T_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw) in map, m² and rad²
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();    ///< in base_stabilized, m/s
  MatchState state = MatchState::kLost;
  /// Direction in map along which the pose is only predicted; zero: none.
  Eigen::Vector2d unobservable = Eigen::Vector2d::Zero();
};

MatchedPose matchedPoseOf(const MapperResult& result, double stamp);

/// The velocity that corrects the next scan for the motion during the sweep: zero while the vehicle
/// is lost.
Eigen::Vector2d knownVelocity(const MapperResult& result);

/// Likewise the yaw rate, rad/s. With an IMU, its gyro is used instead.
double knownYawRate(const MapperResult& result);

/// Gives the pose to the filter, unless the mapper is lost. Returns false if the pose is not used.
bool fuse(const MatchedPose& pose, PoseFilter& filter);

}  // namespace kestrel
