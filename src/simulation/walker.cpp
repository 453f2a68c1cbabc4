// SPDX-License-Identifier: BSD-3-Clause
#include "walker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

// Dimensions of an adult, m.
constexpr double kLegRadius = 0.07;
constexpr double kLegTop = 0.85;
constexpr double kLegOffset = 0.1;  // sideways from the middle
constexpr double kLegSwing = 0.25;  // amplitude forwards and backwards
constexpr double kStride = 1.4;     // two steps
constexpr double kTrunkRadius = 0.2;
constexpr double kTrunkTop = 1.75;
constexpr double kReach = 0.4;  // no part is farther from the middle than this

/// True if the ray, seen from above, passes within kReach of `position`.
bool passesNear(const Ray& ray, const Eigen::Vector2d& position) {
  const Eigen::Vector2d offset = position - ray.origin.head<2>();
  const Eigen::Vector2d along = ray.direction.head<2>();
  const double cross = along.x() * offset.y() - along.y() * offset.x();
  const double length2 = along.squaredNorm(), reach2 = kReach * kReach;
  return cross * cross <= reach2 * length2 &&
         (along.dot(offset) >= 0.0 || offset.squaredNorm() <= reach2);
}

double distanceToSegment(const Eigen::Vector2d& point, const Eigen::Vector2d& from,
                         const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double squared = along.squaredNorm();
  const double share =
      squared > 0.0 ? std::clamp((point - from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (from + share * along - point).norm();
}

}  // namespace

double Walker::distanceToPath(const Eigen::Vector2d& point) const {
  double distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& next = corners[(i + 1) % corners.size()];
    distance = std::min(distance, distanceToSegment(point, corners[i], next));
  }
  return distance;
}

Eigen::Vector2d Walker::at(double time) const { return WalkerPath(*this).at(time).position; }

WalkerPath::WalkerPath(const Walker& walker) : walker_(walker), corner_at_{0.0} {
  const std::vector<Eigen::Vector2d>& corners = walker_.corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& next = corners[(i + 1) % corners.size()];
    corner_at_.push_back(corner_at_.back() + (next - corners[i]).norm());
  }
}

WalkerPath::Step WalkerPath::at(double time) const {
  return alongPath(walker_.phase_m + time * walker_.speed_m_s);
}

WalkerPath::Step WalkerPath::alongPath(double traveled) const {
  const std::vector<Eigen::Vector2d>& corners = walker_.corners;
  const double length = corner_at_.back();
  if (corners.empty()) return {Eigen::Vector2d::Zero(), Eigen::Vector2d::UnitX(), traveled};
  if (length == 0.0) return {corners.front(), Eigen::Vector2d::UnitX(), traveled};
  const double along = traveled - length * std::floor(traveled / length);
  std::size_t side = 0;
  while (side + 1 < corners.size() && corner_at_[side + 1] <= along) ++side;
  const Eigen::Vector2d& from = corners[side];
  const Eigen::Vector2d direction = (corners[(side + 1) % corners.size()] - from).normalized();
  return {from + (along - corner_at_[side]) * direction, direction, traveled};
}

void intersectPerson(const WalkerPath::Step& step, const Ray& ray, RayHit& nearest) {
  if (!passesNear(ray, step.position)) return;
  const Eigen::Vector2d left(-step.direction.y(), step.direction.x());
  const Eigen::Vector2d swing =
      kLegSwing * std::sin(2.0 * kPi * step.traveled / kStride) * step.direction;
  CylinderSolid({step.position + kLegOffset * left + swing, kLegRadius, 0.0, kLegTop})
      .intersect(ray, nearest);
  CylinderSolid({step.position - kLegOffset * left - swing, kLegRadius, 0.0, kLegTop})
      .intersect(ray, nearest);
  CylinderSolid({step.position, kTrunkRadius, kLegTop, kTrunkTop}).intersect(ray, nearest);
}

}  // namespace kestrel
