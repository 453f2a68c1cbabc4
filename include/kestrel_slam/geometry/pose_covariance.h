// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

// Covariances of planar poses, 3x3, in the order x, y, yaw (m², m rad, rad²). There are two kinds:
//
// * In the axes of map, or of another outer frame of the pose. The error is the difference of the
//   components x, y, yaw (offsetBetween). Every "covariance of (x, y, yaw) in map" of this package
//   is of this kind: MatchResult, UncertainPose, PoseMeasurement, the ROS messages.
// * In the tangent space of the pose. The error is t in X = mean * exp(t) (right perturbation), so
//   x and y are along the axes of the pose itself. GaussianPose2 is of this kind, and the Jacobians
//   of Pose2 apply to it.
//
// To first order C_map = S C_tangent S', S = [R(yaw) 0; 0 1]: only the axes are turned. An error on
// the left, exp(t) * mean, would be a third kind, with the covariance Ad C_tangent Ad'
// [Solà 2018, eq. 159]: its x and y are those of the origin of map. It is not used here.

/// A pose and the covariance of its error in its tangent space.
struct GaussianPose2 {
  Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// From the covariance in the axes of map to that in the tangent space of `pose`, and back.
Eigen::Matrix3d tangentCovariance(const Eigen::Matrix3d& in_map, const Pose2& pose);
Eigen::Matrix3d mapCovariance(const Eigen::Matrix3d& in_tangent, const Pose2& pose);

// The functions below are exact to first order in the errors.

/// a⁻¹.
GaussianPose2 inverse(const GaussianPose2& a);

/// a b. The errors of a and b are independent.
GaussianPose2 compose(const GaussianPose2& a, const GaussianPose2& b);

/// a⁻¹ b. `cross` is E[t_a t_b'], as in the joint covariance of a pose graph; zero where the errors
/// are independent.
GaussianPose2 between(const GaussianPose2& a, const GaussianPose2& b,
                      const Eigen::Matrix3d& cross = Eigen::Matrix3d::Zero());

/// The pose of another part of the same rigid body: a * a_T_b, where a_T_b is known exactly.
GaussianPose2 transported(const GaussianPose2& a, const Pose2& a_T_b);

/// The same in the axes of map: the covariance of another point of the same rigid body. `from_to`
/// (in map) leads from the one point to the other; the yaw error moves the second one sideways.
Eigen::Matrix3d transported(const Eigen::Matrix3d& in_map, const Eigen::Vector2d& from_to);

/// The same error in other axes: `b_R_a` is the rotation by `yaw`, the covariance that in a.
Eigen::Matrix3d rotated(const Eigen::Matrix3d& covariance, double yaw);

}  // namespace kestrel
