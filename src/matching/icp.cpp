// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/matching/icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Below this the turn of centerd points is rounding noise, m² a pair.
constexpr double kMinSpread = 1e-9;
/// Steps of one alignment of fixed pairs: two or three are exact from any start of a pairing.
constexpr int kLineSteps = 10;
constexpr double kLineTolerance = 1e-9;
/// Information (1/m², 1/rad²) a pair that holds back what the pairs do not constrain. An hundredth
/// of what noise of the normals feigns along a wall.
constexpr double kDamping = 1e-3;

/// H δ = g of paper 003 eq. 9, linearized at a pose, δ = (x, y, yaw).
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
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector2d p_mean = Eigen::Vector2d::Zero(), q_mean = Eigen::Vector2d::Zero();
  for (const IcpPair& pair : pairs) {
    p_mean += pair.point.cast<double>() / n;
    q_mean += pair.partner.cast<double>() / n;
  }
  double cosine = 0.0, sine = 0.0;  // times the same positive factor
  for (const IcpPair& pair : pairs) {
    const Eigen::Vector2d p = pair.point.cast<double>() - p_mean;
    const Eigen::Vector2d q = pair.partner.cast<double>() - q_mean;
    cosine += p.dot(q) / n;
    sine += (p.x() * q.y() - p.y() * q.x()) / n;
  }
  const bool turned = std::hypot(cosine, sine) > kMinSpread;
  const double yaw = turned ? std::atan2(sine, cosine) : initial_guess.yaw;
  const Eigen::Vector2d shift = q_mean - Eigen::Rotation2Dd(yaw) * p_mean;
  return {shift.x(), shift.y(), yaw};
}

Pose2 alignPointToLine(const std::vector<IcpPair>& pairs, const Pose2& initial_guess) {
  Pose2 pose = initial_guess;
  const double damping = kDamping * static_cast<double>(pairs.size());
  for (int i = 0; i < kLineSteps && !pairs.empty(); ++i) {
    LineEquations equations = linearize(pairs, pose);
    equations.hessian.diagonal().array() += damping;
    const Eigen::Vector3d step = equations.hessian.ldlt().solve(equations.gradient);
    if (!step.allFinite()) break;
    pose = Pose2(pose.x + step.x(), pose.y + step.y(), pose.yaw + step.z());
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
