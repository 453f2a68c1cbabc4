// SPDX-License-Identifier: BSD-3-Clause
#include "localization.h"

#include <algorithm>

#include "kestrel_slam/lidar/cloud_icp.h"
#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {
namespace {

constexpr double kMaxPosition = 1e5;  ///< m; poses beyond this are wrong
/// Share of the surfaces of each direction that fit: twice what chance gives for pairs of any
/// distance up to the reach.
constexpr double kAgreement = 0.3;
/// m/s, m/s², m: faster vehicles are not sought.
constexpr double kMaxLidarSpeed = 40.0, kMaxLidarAcceleration = 10.0, kMaxSearch_m = 4.0;

bool isGood(const CloudIcpResult& icp, double agreement) {
  return icp.converged && agreement >= kAgreement && icp.pose.matrix().allFinite() &&
         icp.pose.translation().norm() < kMaxPosition;
}

}  // namespace

double searchRadius(double seconds, bool is_motion_known) {
  const double change = is_motion_known ? kMaxLidarAcceleration * seconds : kMaxLidarSpeed;
  return std::min(kMaxSearch_m, change * seconds);
}

SweepPlace findSweep(const std::vector<Eigen::Vector3f>& points, const SurfaceMap& map,
                     const CloudTrackerConfig& config, const Eigen::Isometry3d& guess,
                     double radius) {
  if (map.cells().empty()) return {guess, true, false};
  const Voxels voxels = voxelize(points, {}, config.surface_resolution_m);
  std::vector<Eigen::Vector3d> centroids;
  for (const PointSums& sums : voxels.sums) centroids.push_back(sums.mean);
  const CloudIcp icp(map.cells(), config.icp);
  const CloudIcpResult near = icp.align(centroids, guess);
  if (!near.has_pairs) return {guess, false, false};
  // A few pairs do not contradict the pose that is expected, but another one must have them.
  if (isGood(near, near.possible_agreement)) return {near.pose, true, false};
  const CloudIcpResult found = icp.search(centroids, guess, radius);
  if (isGood(found, found.agreement)) return {found.pose, true, false};
  return {guess, false, true};
}

}  // namespace kestrel
