// SPDX-License-Identifier: BSD-3-Clause
#include "covariance_intersection.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "kestrel_slam/geometry/symmetric_axes.h"

namespace kestrel {
namespace {

constexpr int kBisections = 40;

/// Derivative of log det C with respect to the weight. `ratio`: information of the measurement
/// relative to the prior, on the axes on which both are diagonal.
template <int Size>
double slope(const Eigen::Array<double, Size, 1>& ratio, double weight) {
  return -((1.0 - ratio) / (weight + (1.0 - weight) * ratio)).sum();
}

/// Bisection: log det C is convex in the weight.
template <int Size>
double bestWeight(const Eigen::Array<double, Size, 1>& ratio) {
  double low = 0.0, high = 1.0;
  if (slope<Size>(ratio, low) >= 0.0) return low;
  if (slope<Size>(ratio, high) <= 0.0) return high;
  for (int i = 0; i < kBisections; ++i) {
    const double weight = 0.5 * (low + high);
    (slope<Size>(ratio, weight) < 0.0 ? low : high) = weight;
  }
  return 0.5 * (low + high);
}

}  // namespace

template <int Size>
Intersection<Size> intersect(const Eigen::Matrix<double, Size, Size>& prior,
                             const Eigen::Matrix<double, Size, Size>& measured) {
  using Matrix = Eigen::Matrix<double, Size, Size>;
  using Array = Eigen::Array<double, Size, 1>;
  // The axes T diagonalize both: Tᵀ measured T = 1 / ratio, Tᵀ prior T = 1.
  const Matrix root = prior.llt().matrixL();
  const Matrix whitening = root.inverse();
  const SymmetricAxes<Size> axes =
      symmetricAxes(Matrix(whitening * measured * whitening.transpose()));
  const Array ratio = axes.eigenvalues.array().max(1e-12).inverse();
  Intersection<Size> result;
  result.weight = bestWeight<Size>(ratio);
  const Array information = result.weight + (1.0 - result.weight) * ratio;
  const Matrix t = root * axes.eigenvectors;  // the inverse of Tᵀ
  result.covariance = t * information.inverse().matrix().asDiagonal() * t.transpose();
  result.gain = t * ((1.0 - result.weight) * ratio / information).matrix().asDiagonal() *
                axes.eigenvectors.transpose() * whitening;
  return result;
}

template Intersection<2> intersect(const Eigen::Matrix2d&, const Eigen::Matrix2d&);
template Intersection<3> intersect(const Eigen::Matrix3d&, const Eigen::Matrix3d&);

}  // namespace kestrel
