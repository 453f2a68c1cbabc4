// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/geometry/rigid_alignment.h"

#include <cmath>

namespace kestrel {
namespace {

/// Below this the yaw of centered points is rounding noise, m² a pair.
constexpr double kMinSpread = 1e-9;

Eigen::Vector2d meanOf(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  return mean;
}

}  // namespace

Pose2 alignPoints(const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to,
                  double default_yaw) {
  const auto n = static_cast<double>(from.size());
  const Eigen::Vector2d p_mean = meanOf(from), q_mean = meanOf(to);
  double cosine = 0.0, sine = 0.0;  // times the same positive factor
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector2d p = from[i] - p_mean, q = to[i] - q_mean;
    cosine += p.dot(q) / n;
    sine += (p.x() * q.y() - p.y() * q.x()) / n;
  }
  const bool turned = std::hypot(cosine, sine) > kMinSpread;
  const Pose2 rotation(0.0, 0.0, turned ? std::atan2(sine, cosine) : default_yaw);
  const Eigen::Vector2d shift = q_mean - rotation * p_mean;
  return {shift.x(), shift.y(), rotation.yaw};
}

}  // namespace kestrel
