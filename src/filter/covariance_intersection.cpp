// SPDX-License-Identifier: BSD-3-Clause
#include "covariance_intersection.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace kestrel {
namespace {

constexpr int kBisections = 40;

/// Derivative of log det C with respect to the weight. `ratio`: information of the measurement
/// relative to the prior, on the axes on which both are diagonal.
double slope(const Eigen::Array3d& ratio, double weight) {
  return -((1.0 - ratio) / (weight + (1.0 - weight) * ratio)).sum();
}

/// Bisection: log det C is convex in the weight.
double bestWeight(const Eigen::Array3d& ratio) {
  double low = 0.0, high = 1.0;
  if (slope(ratio, low) >= 0.0) return low;
  if (slope(ratio, high) <= 0.0) return high;
  for (int i = 0; i < kBisections; ++i) {
    const double weight = 0.5 * (low + high);
    (slope(ratio, weight) < 0.0 ? low : high) = weight;
  }
  return 0.5 * (low + high);
}

}  // namespace

Intersection intersect(const Eigen::Matrix3d& prior, const Eigen::Matrix3d& measured) {
  // The axes T diagonalize both: Tᵀ measured T = 1 / ratio, Tᵀ prior T = 1.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> axes(measured, prior);
  const Eigen::Array3d ratio = axes.eigenvalues().array().max(1e-12).inverse();
  Intersection result;
  result.weight = bestWeight(ratio);
  const Eigen::Array3d information = result.weight + (1.0 - result.weight) * ratio;
  const Eigen::Matrix3d t = prior * axes.eigenvectors();  // the inverse of Tᵀ
  result.covariance = t * information.inverse().matrix().asDiagonal() * t.transpose();
  result.gain = t * ((1.0 - result.weight) * ratio / information).matrix().asDiagonal() *
                axes.eigenvectors().transpose();
  return result;
}

}  // namespace kestrel
