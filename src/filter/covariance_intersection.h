// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace kestrel {

/// Result of a covariance intersection of a prior with a measurement of the same quantity.
template <int Size>
struct Intersection {
  using Matrix = Eigen::Matrix<double, Size, Size>;
  /// Weight of the prior's information, 0 to 1; that of the measurement is 1 - weight.
  double weight = 1.0;
  Matrix covariance = Matrix::Zero();
  Matrix gain = Matrix::Zero();  ///< estimate = prior + gain * innovation
};

/// Covariance intersection ([Kohlbrecher 2011, sec. V; Julier 1997]): C⁻¹ = w A⁻¹ + (1 - w) B⁻¹. It
/// is never overconfident, for any correlation of the two errors. The weight minimizes the
/// determinant of C, which, unlike the trace, does not depend on the units of the quantities.
/// `prior` and `measured` must be symmetric and positive definite. Size: 2 or 3.
template <int Size>
Intersection<Size> intersect(const Eigen::Matrix<double, Size, Size>& prior,
                             const Eigen::Matrix<double, Size, Size>& measured);

}  // namespace kestrel
