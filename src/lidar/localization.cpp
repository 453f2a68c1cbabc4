// SPDX-License-Identifier: BSD-3-Clause
#include "localization.h"

#include <algorithm>

#include "kestrel_slam/lidar/cloud_icp.h"
#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {
namespace {

constexpr double kMaxPosition = 1e5;  ///< m; poses beyond this are wrong
/// Share of the surfaces of each direction that fit: twice what chance gives for pairs of any
/// distance up to the reach. And share of what stands that has a surface of the map near it: what
/// was seen 0.1 s before is mostly there.
constexpr double kAgreement = 0.3;
constexpr std::size_t kOverlapPoints = 1000;
/// m/s, m/s², m: faster vehicles are not sought.
constexpr double kMaxLidarSpeed = 40.0, kMaxLidarAcceleration = 10.0, kMaxSearch_m = 4.0;

/// Share of the points that are near to something in the map; 1 without points.
double overlapOf(const std::vector<Eigen::Vector3d>& points, const Eigen::Isometry3d& pose,
                 const SurfaceMap& map) {
  const std::size_t step = 1 + points.size() / kOverlapPoints;
  std::size_t count = 0, near = 0;
  for (std::size_t i = 0; i < points.size(); i += step, ++count) {
    if (map.isNear((pose * points[i]).cast<float>())) ++near;
  }
  return count > 0 ? static_cast<double>(near) / static_cast<double>(count) : 1.0;
}

bool isGood(const CloudIcpResult& icp, double agreement, double overlap) {
  return icp.converged && std::min(agreement, overlap) >= kAgreement &&
         icp.pose.matrix().allFinite() && icp.pose.translation().norm() < kMaxPosition;
}

}  // namespace

double searchRadius(double seconds, bool is_motion_known) {
  const double change = is_motion_known ? kMaxLidarAcceleration * seconds : kMaxLidarSpeed;
  return std::min(kMaxSearch_m, change * seconds);
}

SweepPlace findSweep(const std::vector<Eigen::Vector3f>& points, const Ground& ground,
                     const SurfaceMap& map, const CloudTrackerConfig& config,
                     const Eigen::Isometry3d& guess, double radius) {
  if (map.cells().empty()) return {guess, true, false};
  const Voxels voxels = voxelize(points, {}, config.surface_resolution_m);
  const std::vector<Eigen::Vector3f> floor =
      groundNormals(ground, voxels, Eigen::Isometry3d::Identity());
  std::vector<Eigen::Vector3d> centroids, standing;
  for (std::size_t v = 0; v < voxels.sums.size(); ++v) {
    centroids.push_back(voxels.sums[v].mean);
    if (floor[v].isZero()) standing.push_back(voxels.sums[v].mean);
  }
  const CloudIcp icp(map.cells(), config.icp);
  const CloudIcpResult near = icp.align(centroids, guess);
  if (!near.has_pairs) return {guess, false, false};
  // A few pairs do not contradict the pose that is expected, but another one must have them.
  if (isGood(near, near.possible_agreement, overlapOf(standing, near.pose, map)))
    return {near.pose, true, false};
  const CloudIcpResult found = icp.search(centroids, guess, radius);
  if (isGood(found, found.agreement, overlapOf(standing, found.pose, map)))
    return {found.pose, true, false};
  return {guess, false, true};
}

}  // namespace kestrel
