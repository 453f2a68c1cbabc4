// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/covariance.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "kestrel_slam/geometry/symmetric_axes.h"

namespace kestrel {
namespace {

/// Added to the Hessian, because that of an empty scan is zero.
constexpr double kLeastShare = 1e-3;
/// Distance of the samples, in standard deviations of the spread.
constexpr double kSampleSigmas = 1.0;
/// Limits the covariance of a flat likelihood to 25 times the spread, since the samples do not show
/// the cost farther away.
constexpr double kLeastCurvature = 0.04;

}  // namespace

Eigen::Matrix3d hessianCovariance(const Eigen::Matrix3d& hessian, double variance) {
  const Eigen::Matrix3d inverse = (hessian + kLeastShare * Eigen::Matrix3d::Identity())
                                      .ldlt()
                                      .solve(Eigen::Matrix3d::Identity());
  return variance * 0.5 * (inverse + inverse.transpose());
}

Eigen::Matrix3d sampledCovariance(const std::function<double(const Pose2&)>& cost,
                                  const Pose2& result, const Eigen::Matrix3d& spread,
                                  double variance) {
  // With a square root L of the spread, the costs along and between its columns give the curvature
  // C = L' Λ L, where Λ is the information matrix. The covariance is Λ⁻¹ = L C⁻¹ L'.
  const Eigen::Matrix3d root = spread.llt().matrixL();
  const double at_result = cost(result);
  const auto costAt = [&](const Eigen::Vector3d& whitened) {
    return (cost(addOffset(result, root * whitened)) - at_result) / variance;
  };
  // The mean of both sides, because the result may not be exactly at the minimum.
  const auto rise = [&](const Eigen::Vector3d& step) {
    return 0.5 * (costAt(step) + costAt(-step));
  };
  constexpr double kStep2 = kSampleSigmas * kSampleSigmas;
  Eigen::Matrix3d curvature;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d along = kSampleSigmas * Eigen::Vector3d::Unit(i);
    curvature(i, i) = 2.0 * rise(along) / kStep2;
    for (int j = 0; j < i; ++j) {
      const Eigen::Vector3d other = kSampleSigmas * Eigen::Vector3d::Unit(j);
      curvature(i, j) = curvature(j, i) =
          0.5 * (rise(along + other) - rise(along - other)) / kStep2;
    }
  }
  const SymmetricAxes<3> axes = symmetricAxes(curvature);
  const Eigen::Vector3d inverse = axes.eigenvalues.cwiseMax(kLeastCurvature).cwiseInverse();
  const Eigen::Matrix3d shape = root * axes.eigenvectors;
  const Eigen::Matrix3d covariance = shape * inverse.asDiagonal() * shape.transpose();
  return covariance.allFinite() ? covariance : spread;  // the spread may have no square root
}

Eigen::Matrix3d stretched(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& direction,
                          double factor) {
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
  stretch.topLeftCorner<2, 2>() += (factor - 1.0) * direction * direction.transpose();
  return stretch * covariance * stretch;
}

}  // namespace kestrel
