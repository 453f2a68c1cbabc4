// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

namespace kestrel {

/// Result of a covariance intersection of a prior with a measurement of the same quantity.
struct Intersection {
  double weight = 1.0;  ///< of the prior's information, 0 to 1; the measurement's has the rest
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d gain = Eigen::Matrix3d::Zero();  ///< estimate = prior + gain * innovation
};

/// Covariance intersection (paper 001 section V; Julier and Uhlmann 1997): C⁻¹ = w A⁻¹ + (1 - w)
/// B⁻¹, which claims no more than is known however the errors of the two are correlated. The
/// weight is the one with the smallest determinant of C: unlike the trace, it does not depend on
/// the units of the quantities. `prior` and `measured`: symmetric and positive definite.
Intersection intersect(const Eigen::Matrix3d& prior, const Eigen::Matrix3d& measured);

}  // namespace kestrel
