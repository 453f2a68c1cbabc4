// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

// The two methods of [Kohlbrecher 2011, sec. IV-B] for the covariance of a match. The unit of the
// cost is 0.5 d² (m², d: distance of a point to its wall). `variance` is the variance of d of one
// independent point, m². The result is the covariance of (x, y, yaw) in the map frame, m² and rad².

/// From the approximate Hessian of the cost at the result: R = σ² H⁻¹ [Kohlbrecher 2011, eq. 15].
Eigen::Matrix3d hessianCovariance(const Eigen::Matrix3d& hessian, double variance);

/// From the cost at 18 poses around the result, similar to the sigma points of an unscented
/// transform: the Gaussian that has the likelihood exp(-cost / σ²) at these poses. The covariance
/// `spread` sets the distance of the poses. In contrast to the Hessian, this also measures the cost
/// at some distance from the result.
Eigen::Matrix3d sampledCovariance(const std::function<double(const Pose2&)>& cost,
                                  const Pose2& result, const Eigen::Matrix3d& spread,
                                  double variance);

/// Multiplies the standard deviation along the unit vector `direction` (map frame) by `factor`.
/// Correlations do not change.
Eigen::Matrix3d stretched(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& direction,
                          double factor);

}  // namespace kestrel
