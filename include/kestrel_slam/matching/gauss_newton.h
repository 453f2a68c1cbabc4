// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/map/surfel_field.h"

namespace kestrel {

/// Parameters of the iterated Gauss-Newton method with damping and robust weights.
struct GaussNewtonConfig {
  int max_iterations = 15;     ///< per stage
  double min_step_m = 6e-4;    ///< converged if a step is smaller than this,
  double min_step_rad = 4e-4;  ///< and this
};

/// Linearization at a pose: H δ = g with δ = (x, y, yaw) [Kohlbrecher 2011, eq. 12-13].
struct NormalEquations {
  Eigen::Matrix3f hessian = Eigen::Matrix3f::Zero();
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  ///< g, the direction of decreasing cost
  float cost = 0.0F;                                   ///< robust cost, to be minimized
};

/// The residual is the distance to the walls of `surface`, with Cauchy weights of scale `scale_m`.
/// A point without a wall within reach has the cost of a point at the end of the reach.
NormalEquations linearizeDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m);

/// The residual is 1 - M(S_i(ξ)) on a level of the grid [Kohlbrecher 2011, eq. 7-14], with Cauchy
/// weights of scale `scale`.
NormalEquations linearizeOccupancy(const OccupancyGrid& grid, int level, const Points& points,
                                   const Pose2& map_T_base, float scale);

/// Result of a descent.
struct Descent {
  Pose2 pose;
  NormalEquations at_pose;
  int iterations = 0;
  bool converged = false;
};

/// Gauss-Newton with Levenberg-Marquardt damping: a step that does not decrease the cost is
/// rejected and shortened. `linearize(pose)` returns the normal equations. A weak prior at
/// `initial_guess` with `prior_information` (1/m², 1/m², 1/rad², per unit of cost) keeps
/// unobservable directions at the initial guess.
template <typename Linearize>
Descent descend(const Pose2& initial_guess, const GaussNewtonConfig& config,
                const Eigen::Vector3f& prior_information, Linearize linearize) {
  constexpr float kFirstDamping = 1e-3F, kDampingUp = 10.0F, kDampingDown = 0.1F;
  constexpr float kMaxDamping = 1e3F;
  const auto withPrior = [&](const Pose2& pose) {
    NormalEquations equations = linearize(pose);
    const Eigen::Vector3f offset(static_cast<float>(pose.x - initial_guess.x),
                                 static_cast<float>(pose.y - initial_guess.y),
                                 static_cast<float>(normalizeAngle(pose.yaw - initial_guess.yaw)));
    equations.hessian.diagonal() += prior_information;
    equations.gradient -= prior_information.cwiseProduct(offset);
    equations.cost += 0.5F * offset.dot(prior_information.cwiseProduct(offset));
    return equations;
  };
  Descent best;
  best.pose = initial_guess;
  best.at_pose = withPrior(initial_guess);
  float damping = kFirstDamping;
  for (; best.iterations < config.max_iterations && damping < kMaxDamping; ++best.iterations) {
    Eigen::Matrix3f damped = best.at_pose.hessian;
    damped.diagonal() += damping * best.at_pose.hessian.diagonal();
    damped.diagonal().array() += 1e-6F;  // the Hessian of an empty scan is zero
    const Eigen::Vector3f step = damped.ldlt().solve(best.at_pose.gradient);
    if (!step.allFinite()) break;
    const Pose2 pose(best.pose.x + static_cast<double>(step.x()),
                     best.pose.y + static_cast<double>(step.y()),
                     best.pose.yaw + static_cast<double>(step.z()));
    const bool small = static_cast<double>(step.head<2>().norm()) < config.min_step_m &&
                       static_cast<double>(std::abs(step.z())) < config.min_step_rad;
    if (small) {
      best.pose = pose;
      best.converged = true;
      break;
    }
    const NormalEquations equations = withPrior(pose);
    if (equations.cost < best.at_pose.cost) {
      best.pose = pose;
      best.at_pose = equations;
      damping *= kDampingDown;
    } else {
      damping *= kDampingUp;
    }
  }
  return best;
}

}  // namespace kestrel
