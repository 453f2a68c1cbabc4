// SPDX-License-Identifier: BSD-3-Clause
#include "vehicle_mask.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

constexpr float kSameRange = 0.05F;  ///< m; noise of the laser and give of the parts
/// The vehicle must travel this far, m, until a return that stays belongs to it. Wheels and chairs
/// are smaller; walls along the way stay as well, but walls do not move anyway.
constexpr float kTravel = 1.0F;
constexpr double kTurnArm = 0.5;  ///< m; a turn by 1 rad counts as this way

/// Bearing of a point to 2e-5 rad (a polynomial of Hastings); NaN of the origin.
float roughBearing(const Eigen::Vector2f& point) {
  const float x = std::abs(point.x()), y = std::abs(point.y());
  const float slope = std::min(x, y) / std::max(x, y), s2 = slope * slope;
  float angle = 0.0208351F;
  for (const float factor : {-0.0851330F, 0.1801410F, -0.3302995F, 0.9998660F}) {
    angle = angle * s2 + factor;
  }
  angle *= slope;
  if (y > x) angle = static_cast<float>(kPi / 2.0) - angle;
  if (point.x() < 0.0F) angle = static_cast<float>(kPi) - angle;
  return point.y() < 0.0F ? -angle : angle;
}

/// Number of one of `count` equal sectors. The exact bearing is only needed near a border.
std::size_t sectorOf(const Eigen::Vector2f& point, int count) {
  constexpr float kBorder = 0.01F;  // sectors; 720 of them are 0.0087 rad wide
  const auto per_radian = static_cast<float>(count / (2.0 * kPi));
  const float rough = (roughBearing(point) + static_cast<float>(kPi)) * per_radian;
  if (rough > 0.0F) {
    const int whole = static_cast<int>(rough);
    const float within = rough - static_cast<float>(whole);
    if (within > kBorder && within < 1.0F - kBorder) return static_cast<std::size_t>(whole);
  }
  const auto bearing = static_cast<double>(std::atan2(point.y(), point.x()));
  return static_cast<std::size_t>((bearing + kPi) / (2.0 * kPi) * count) %
         static_cast<std::size_t>(count);
}

}  // namespace

VehicleMask::VehicleMask() : bins_(kBins) {}

std::vector<bool> VehicleMask::update(const PlanarScan& scan, const Pose2& odom_T_base) {
  const Pose2 step = has_last_ ? last_.inverse() * odom_T_base : Pose2();
  const auto traveled = static_cast<float>(step.distance() + kTurnArm * std::abs(step.yaw));
  last_ = odom_T_base;
  has_last_ = true;
  for (Bin& bin : bins_) bin.traveled += traveled;
  std::vector<bool> mask(scan.rays.size(), false);
  std::vector<char> stays(kBins, 0), seen(kBins, 0);
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    const PlanarRay& ray = scan.rays[i];
    if (!ray.hit || !ray.end.allFinite()) continue;
    const std::size_t number = sectorOf(ray.end, kBins);
    Bin& bin = bins_[number];
    const float range = ray.end.norm();
    if (std::abs(range - bin.range) <= kSameRange) {
      stays[number] = 1;
      mask[i] = bin.traveled > kTravel;
    } else if (stays[number] == 0 && seen[number] == 0) {
      bin = {range, 0.0F};
    }
    seen[number] = 1;
  }
  return mask;
}

}  // namespace kestrel
