// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/ground.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

using Points3 = std::vector<Eigen::Vector3f>;

constexpr int kTrials = 60;           ///< of RANSAC: half of the points suffice, with 1e-3 risk
constexpr std::size_t kSample = 600;  ///< points that vote for a plane
constexpr std::size_t kFewest = 30;   ///< points of a quadrant
/// The ground is around the lidar; what is flat in one direction only may be a hedge or a roof.
constexpr std::ptrdiff_t kFewestPlanes = 3;
constexpr double kMajority = 0.5;  ///< share of the lowest points that a ground has
constexpr std::uint64_t kSeed = 4;

std::size_t quadrantOf(const Eigen::Vector3f& point) {
  return (point.x() < 0.0F ? 1U : 0U) + (point.y() < 0.0F ? 2U : 0U);
}

std::optional<GroundPlane> planeOf(Eigen::Vector3f normal, const Eigen::Vector3f& point,
                                   float least_up) {
  const float length = normal.norm();
  if (!(length > 0.0F)) return std::nullopt;
  normal /= normal.z() < 0.0F ? -length : length;
  if (normal.z() < least_up) return std::nullopt;
  return GroundPlane{normal, -normal.dot(point)};
}

std::size_t inliersOf(const GroundPlane& plane, const Points3& points, float distance) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(),
      [&](const Eigen::Vector3f& p) { return std::abs(plane.heightOf(p)) < distance; }));
}

/// Every n-th point, so that at most kSample are left.
Points3 sampleOf(const Points3& points) {
  const std::size_t step = (points.size() + kSample - 1) / kSample;
  Points3 sample;
  for (std::size_t i = 0; i < points.size(); i += step) sample.push_back(points[i]);
  return sample;
}

/// Least squares over the inliers.
std::optional<GroundPlane> refine(const GroundPlane& plane, const Points3& points, float distance,
                                  float least_up) {
  PointSums sums;
  for (const Eigen::Vector3f& point : points) {
    if (std::abs(plane.heightOf(point)) < distance) sums.add(point.cast<double>());
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(sums.spread);
  return planeOf(solver.eigenvectors().col(0).cast<float>(), sums.mean.cast<float>(), least_up);
}

std::optional<GroundPlane> ransac(const Points3& points, const GroundConfig& config) {
  const auto least_up = static_cast<float>(std::cos(config.max_slope_deg * kPi / 180.0));
  const auto distance = static_cast<float>(config.inlier_m);
  const Points3 sample = sampleOf(points);
  Random random(kSeed);
  const auto any = [&] {
    return sample[static_cast<std::size_t>(random.uniform() * static_cast<double>(sample.size()))];
  };
  std::optional<GroundPlane> best;
  std::size_t most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector3f a = any(), b = any(), c = any();
    const auto plane = planeOf((b - a).cross(c - a), a, least_up);
    if (!plane) continue;
    const std::size_t inliers = inliersOf(*plane, sample, distance);
    if (inliers <= most) continue;
    most = inliers;
    best = plane;
  }
  // Where no ground is seen, the lowest points lie on walls, at all heights.
  if (static_cast<double>(most) < kMajority * static_cast<double>(sample.size())) return {};
  return refine(*best, points, distance, least_up);
}

/// The lowest points of each quadrant.
std::array<Points3, 4> lowestPoints(const Points3& points, const GroundConfig& config) {
  std::array<Points3, 4> lowest;
  for (const Eigen::Vector3f& point : points) {
    if (point.head<2>().norm() < static_cast<float>(config.reach_m))
      lowest[quadrantOf(point)].push_back(point);
  }
  for (Points3& quadrant : lowest) {
    const auto kept =
        static_cast<std::size_t>(config.lowest_share * static_cast<double>(quadrant.size()));
    std::nth_element(quadrant.begin(), quadrant.begin() + static_cast<std::ptrdiff_t>(kept),
                     quadrant.end(), [](const auto& a, const auto& b) { return a.z() < b.z(); });
    quadrant.resize(kept);
  }
  return lowest;
}

}  // namespace

const std::optional<GroundPlane>& Ground::planeAt(const Eigen::Vector3f& point) const {
  return planes[quadrantOf(point)];
}

Ground findGround(const Points3& points, const GroundConfig& config) {
  Ground ground;
  const std::array<Points3, 4> lowest = lowestPoints(points, config);
  for (std::size_t i = 0; i < lowest.size(); ++i) {
    if (lowest[i].size() >= kFewest) ground.planes[i] = ransac(lowest[i], config);
  }
  ground.is_ground.assign(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::optional<GroundPlane>& plane = ground.planeAt(points[i]);
    ground.is_ground[i] =
        plane && std::abs(plane->heightOf(points[i])) < static_cast<float>(config.height_m);
  }
  return ground;
}

std::vector<Eigen::Vector3f> groundNormals(const Ground& ground, const Voxels& voxels,
                                           const Eigen::Isometry3d& frame_T_lidar) {
  std::vector<Eigen::Vector3f> normals(voxels.sums.size(), Eigen::Vector3f::Zero());
  const auto planes = std::count_if(ground.planes.begin(), ground.planes.end(),
                                    [](const auto& plane) { return plane.has_value(); });
  if (planes < kFewestPlanes) return normals;
  std::vector<bool> is_ground(voxels.sums.size(), true);
  for (std::size_t i = 0; i < ground.is_ground.size(); ++i) {
    const std::uint32_t v = voxels.voxel_of[i];
    if (v != VoxelTable::kNone && !ground.is_ground[i]) is_ground[v] = false;
  }
  const Eigen::Isometry3d to_lidar = frame_T_lidar.inverse();
  const Eigen::Matrix3f rotation = frame_T_lidar.linear().cast<float>();
  for (std::size_t v = 0; v < normals.size(); ++v) {
    if (!is_ground[v]) continue;
    const auto& plane = ground.planeAt((to_lidar * voxels.sums[v].mean).cast<float>());
    if (plane) normals[v] = rotation * plane->normal;
  }
  return normals;
}

}  // namespace kestrel
