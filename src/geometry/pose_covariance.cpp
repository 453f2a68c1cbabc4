// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/pose_covariance.h"

namespace kestrel {
namespace {

Eigen::Matrix3d propagated(const Eigen::Matrix3d& jacobian, const Eigen::Matrix3d& covariance) {
  return jacobian * covariance * jacobian.transpose();
}

}  // namespace

Eigen::Matrix3d rotated(const Eigen::Matrix3d& covariance, double yaw) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian.topLeftCorner<2, 2>() = Pose2(0.0, 0.0, yaw).rotation();
  return propagated(jacobian, covariance);
}

Eigen::Matrix3d tangentCovariance(const Eigen::Matrix3d& in_map, const Pose2& pose) {
  return rotated(in_map, -pose.yaw);
}

Eigen::Matrix3d mapCovariance(const Eigen::Matrix3d& in_tangent, const Pose2& pose) {
  return rotated(in_tangent, pose.yaw);
}

GaussianPose2 inverse(const GaussianPose2& a) {
  Eigen::Matrix3d J_inverse_a;
  const Pose2 mean = a.mean.inverse(&J_inverse_a);
  return {mean, propagated(J_inverse_a, a.covariance)};
}

GaussianPose2 compose(const GaussianPose2& a, const GaussianPose2& b) {
  Eigen::Matrix3d J_c_a;  // that for b is the identity
  const Pose2 mean = a.mean.compose(b.mean, &J_c_a);
  return {mean, propagated(J_c_a, a.covariance) + b.covariance};
}

GaussianPose2 between(const GaussianPose2& a, const GaussianPose2& b,
                      const Eigen::Matrix3d& cross) {
  Eigen::Matrix3d J_c_a;  // that for b is the identity
  const Pose2 mean = a.mean.between(b.mean, &J_c_a);
  const Eigen::Matrix3d mixed = J_c_a * cross;
  return {mean, propagated(J_c_a, a.covariance) + b.covariance + mixed + mixed.transpose()};
}

GaussianPose2 transported(const GaussianPose2& a, const Pose2& a_T_b) {
  return compose(a, {a_T_b, Eigen::Matrix3d::Zero()});
}

Eigen::Matrix3d transported(const Eigen::Matrix3d& in_map, const Eigen::Vector2d& from_to) {
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity();
  jacobian(0, 2) = -from_to.y();
  jacobian(1, 2) = from_to.x();
  return propagated(jacobian, in_map);
}

}  // namespace kestrel
