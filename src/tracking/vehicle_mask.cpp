// SPDX-License-Identifier: BSD-3-Clause
#include "vehicle_mask.h"

#include <algorithm>
#include <cmath>

#include "sectors.h"

namespace kestrel {
namespace {

constexpr float kSameRange = 0.05F;  ///< m; noise of the laser and give of the parts
/// The vehicle must travel this far, m, until a return that stays belongs to it. Wheels and chairs
/// are smaller; walls along the way stay as well, but walls do not move anyway.
constexpr float kTravel = 1.0F;
constexpr double kTurnArm = 0.5;  ///< m; a turn by 1 rad counts as this way

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
  static const Sectors sectors(kBins);
  int sector = 0;
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    const PlanarRay& ray = scan.rays[i];
    if (!ray.hit || !ray.end.allFinite()) continue;
    sector = sectors.of(ray.end, sector);
    const auto number = static_cast<std::size_t>(sector);
    Bin& bin = bins_[number];
    const float range = ray.end.norm();
    if (std::abs(range - bin.range) <= kSameRange) {
      stays[number] = 1;
      if (bin.traveled > kTravel) mask[i] = true;
    } else if (stays[number] == 0 && seen[number] == 0) {
      bin = {range, 0.0F};
    }
    seen[number] = 1;
  }
  return mask;
}

}  // namespace kestrel
