// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/rigid_alignment.h"

namespace kestrel {
namespace {

/// Maximum number of steps to align fixed pairs; two or three are usually enough.
constexpr int kLineSteps = 10;
constexpr double kLineTolerance = 1e-9;
/// Information (1/m², 1/rad²) per pair that keeps unobservable directions at the initial guess.
/// 1/100 of the false information along a wall that noise of the normals causes.
constexpr double kDamping = 1e-3;

/// H δ = g of [Siew 2018, eq. 9], linearized at a pose, δ = (x, y, yaw).
struct LineEquations {
  Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();

  void add(const Eigen::Vector2d& normal, const Eigen::Vector2d& arm, const Eigen::Vector2d& e) {
    const Eigen::Vector3d j(normal.x(), normal.y(), normal.dot(arm));
    hessian += j * j.transpose();
    gradient -= j * normal.dot(e);
  }
};

LineEquations linearize(const std::vector<IcpPair>& pairs, const Pose2& pose) {
  const Eigen::Rotation2Dd turn(pose.yaw);
  LineEquations equations;
  for (const IcpPair& pair : pairs) {
    const Eigen::Vector2d turned = turn * pair.point.cast<double>();
    const Eigen::Vector2d arm(-turned.y(), turned.x());
    const Eigen::Vector2d e = pose.translation() + turned - pair.partner.cast<double>();
    if (pair.normal.isZero(0.0F)) {
      equations.add(Eigen::Vector2d::UnitX(), arm, e);
      equations.add(Eigen::Vector2d::UnitY(), arm, e);
    } else {
      equations.add(pair.normal.cast<double>(), arm, e);
    }
  }
  return equations;
}

}  // namespace

Pose2 alignPointToPoint(const std::vector<IcpPair>& pairs, const Pose2& initial_guess) {
  if (pairs.empty()) return initial_guess;
  std::vector<Eigen::Vector2d> points, partners;
  points.reserve(pairs.size());
  partners.reserve(pairs.size());
  for (const IcpPair& pair : pairs) {
    points.push_back(pair.point.cast<double>());
    partners.push_back(pair.partner.cast<double>());
  }
  return alignPoints(points, partners, initial_guess.yaw);
}

Pose2 alignPointToLine(const std::vector<IcpPair>& pairs, const Pose2& initial_guess) {
  Pose2 pose = initial_guess;
  const double damping = kDamping * static_cast<double>(pairs.size());
  for (int i = 0; i < kLineSteps && !pairs.empty(); ++i) {
    LineEquations equations = linearize(pairs, pose);
    equations.hessian.diagonal().array() += damping;
    const Eigen::Vector3d step = equations.hessian.ldlt().solve(equations.gradient);
    if (!step.allFinite()) break;
    pose = addOffset(pose, step);
    if (step.cwiseAbs().maxCoeff() < kLineTolerance) break;
  }
  return pose;
}

void rejectWorstPairs(std::vector<IcpPair>& pairs, double share) {
  const auto rejected = static_cast<std::size_t>(share * static_cast<double>(pairs.size()));
  const auto kept = pairs.end() - static_cast<std::ptrdiff_t>(rejected);
  std::nth_element(pairs.begin(), kept, pairs.end(),
                   [](const IcpPair& a, const IcpPair& b) { return a.error < b.error; });
  pairs.erase(kept, pairs.end());
}

}  // namespace kestrel
