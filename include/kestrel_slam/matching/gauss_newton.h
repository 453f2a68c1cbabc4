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

/// End points of the hits of a scan in the base frame, m.

/// Parameters of the iterated, damped, robust Gauss-Newton method.
struct GaussNewtonConfig {
  int max_iterations = 15;     ///< per stage
  double min_step_m = 6e-4;    ///< converged when a step is smaller than this,
  double min_step_rad = 4e-4;  ///< and this
};

/// One linearization at a pose: H δ = g (paper 001 eq. 12-13) with δ = (x, y, yaw).
struct NormalEquations {
  Eigen::Matrix3f hessian = Eigen::Matrix3f::Zero();
  Eigen::Vector3f gradient = Eigen::Vector3f::Zero();  ///< points downhill
  float cost = 0.0F;                                   ///< robust cost, to be minimized
};

/// Distance to the walls of `surface` as residual, with the Cauchy weight of scale `scale_m`.
/// Points without a wall in reach cost as much as one at the reach.
NormalEquations linearizeDistance(const SurfelField& surface, const Points& points,
                                  const Pose2& map_T_base, float scale_m);

/// 1 - M(S_i(ξ)) on a level of the grid as residual (paper 001 eq. 7-14), with a Cauchy weight.
NormalEquations linearizeOccupancy(const OccupancyGrid& grid, int level, const Points& points,
                                   const Pose2& map_T_base, float scale);

/// Where a descent ended.
struct Descent {
  Pose2 pose;
  NormalEquations at_pose;
  int iterations = 0;
  bool converged = false;
};

/// Gauss-Newton from `initial_guess`, damped as Levenberg and Marquardt: a step that does not lower
/// the cost is taken back and shortened. `linearize(pose)` gives the normal equations. A weak pull
/// of `prior_information` (1/m², 1/m², 1/rad², per unit of cost) ties the result to `initial_guess`
/// where the scan says nothing.
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
    damped.diagonal().array() += 1e-6F;  // an empty scan has no Hessian at all
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
