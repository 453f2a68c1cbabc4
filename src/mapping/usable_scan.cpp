// SPDX-License-Identifier: BSD-3-Clause
#include "usable_scan.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/mapping/motion_model.h"

namespace kestrel {
namespace {

/// Larger coordinates of a ray, m, and coordinates that are not finite are invalid.
constexpr float kMaxRayM = 1e4F;
/// Larger times, and times that are not finite, are invalid, s.
constexpr double kMaxTime = 1e12;

bool isUsable(const PlanarRay& ray) {
  // The comparisons are false for NaN.
  return ray.origin.cwiseAbs().sum() < kMaxRayM && ray.end.cwiseAbs().sum() < kMaxRayM;
}

bool isUsableTime(double time) { return std::abs(time) < kMaxTime; }

}  // namespace

bool isUsable(const PlanarScan& scan) {
  return isUsableTime(scan.time) &&
         std::all_of(scan.rays.begin(), scan.rays.end(),
                     [](const PlanarRay& ray) { return isUsable(ray); }) &&
         (!scan.integrated_yaw || std::isfinite(*scan.integrated_yaw)) &&
         (!scan.integrated_acceleration || scan.integrated_acceleration->allFinite()) &&
         (!scan.predicted || isUsable(*scan.predicted));
}

PlanarScan repaired(const PlanarScan& scan, double last_time) {
  PlanarScan result = scan;
  if (!isUsableTime(result.time)) result.time = last_time;
  const auto broken = [](const PlanarRay& ray) { return !isUsable(ray); };
  result.rays.erase(std::remove_if(result.rays.begin(), result.rays.end(), broken),
                    result.rays.end());
  if (result.integrated_yaw && !std::isfinite(*result.integrated_yaw))
    result.integrated_yaw.reset();
  if (result.integrated_acceleration && !result.integrated_acceleration->allFinite())
    result.integrated_acceleration.reset();
  if (result.predicted && !isUsable(*result.predicted)) result.predicted.reset();
  return result;
}

}  // namespace kestrel
