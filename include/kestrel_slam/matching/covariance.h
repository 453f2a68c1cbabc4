// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <functional>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

// The two ways of paper 001, section IV-B, to the covariance of a match. Both take a cost in the
// unit of 0.5 d² (m², d the distance of a point to its wall) and the variance of d that one
// independent point has (m²), and give the covariance of (x, y, yaw) in map, m² and rad².

/// From the approximate Hessian of the cost at the result: R = σ² H⁻¹ (paper 001 eq. 15).
Eigen::Matrix3d hessianCovariance(const Eigen::Matrix3d& hessian, double variance);

/// From the cost at 18 poses around the result, as with the points of an unscented transform: the
/// Gaussian that has the likelihood exp(-cost / σ²) of those poses. `spread` is the covariance
/// that says how far away they are; it sees what the cost does there, not only its tangent.
Eigen::Matrix3d sampledCovariance(const std::function<double(const Pose2&)>& cost,
                                  const Pose2& result, const Eigen::Matrix3d& spread,
                                  double variance);

/// `covariance` with its standard deviation along the unit vector `direction` (in map) times
/// `factor`; correlations stay.
Eigen::Matrix3d stretched(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& direction,
                          double factor);

/// Moves a covariance from `from` to `to`, as if both were one rigid body: what an error in yaw
/// at `from` does to the position of `to`. Both poses and all covariances are in map.
Eigen::Matrix3d transported(const Eigen::Matrix3d& covariance, const Eigen::Vector2d& from_to);

}  // namespace kestrel
