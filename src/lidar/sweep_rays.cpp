// SPDX-License-Identifier: BSD-3-Clause
#include "sweep_rays.h"

#include <algorithm>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/lidar/visitation.h"

namespace kestrel {
namespace {

/// Beams without return are thinned to this distance (m) at this range (m).
constexpr double kUnansweredStep = 1.0;
constexpr float kUnansweredRange = 20.0F;

}  // namespace

/// The beam to `end`, up to the range in which beams clear cells.
GridRay<3> SweepRays::rayTo(const Eigen::Vector3f& end, float shorter) const {
  const Eigen::Vector3f from = pose_.translation().cast<float>(), along = end - from;
  const float range = along.norm();
  const auto limit = static_cast<float>(config_.free_range_m);
  GridRay<3> ray{from, end, shorter <= 0.0F && range <= limit, false};
  if (!ray.hit) ray.end = from + along * (std::clamp(range - shorter, 0.0F, limit) / range);
  return ray;
}

std::vector<GridRay<3>> SweepRays::measured(const Voxels& voxels, const Voxels& ground) const {
  std::vector<GridRay<3>> rays;
  rays.reserve(voxels.sums.size() + ground.sums.size());
  for (const PointSums& sums : voxels.sums) rays.push_back(rayTo(sums.mean.cast<float>(), 0.0F));
  const auto shorter = static_cast<float>(config_.grid.resolution_m);
  for (const PointSums& sums : ground.sums) {
    rays.push_back(rayTo(sums.mean.cast<float>(), shorter));
  }
  return rays;
}

/// Where a beam without return meets something static: glass and dark surfaces give no return.
Eigen::Vector3f SweepRays::freeEnd(const Eigen::Vector3f& to) const {
  const Eigen::Vector3f from = pose_.translation().cast<float>();
  const auto inverse = static_cast<float>(1.0 / config_.grid.resolution_m);
  Eigen::Vector3f end = to;
  traverse<3>(from * inverse, to * inverse, [&](const GridIndex<3>& index) {
    if (grid_.staticState(index) != CellState::kOccupied) return true;
    const float range = (grid_.centerOf(index) - from).norm();
    end = from + (to - from).normalized() * std::max(0.0F, range - 1.0F / inverse);
    return false;
  });
  return end;
}

void SweepRays::addDirections(const std::vector<Eigen::Vector3f>& directions,
                              std::vector<GridRay<3>>& rays) const {
  const Eigen::Isometry3f pose = pose_.cast<float>();
  VoxelTable used;
  for (const Eigen::Vector3f& direction : directions) {
    if (!direction.allFinite()) continue;
    const std::size_t known = used.size();
    used.numberOf(voxelIndexOf(direction * kUnansweredRange, kUnansweredStep));
    if (used.size() == known) continue;
    const Eigen::Vector3f end =
        pose * (direction * static_cast<float>(config_.free_range_m)).eval();
    rays.push_back({pose.translation(), freeEnd(end), false, false});
  }
}

void SweepRays::addUnanswered(const std::vector<Eigen::Vector3f>& directions,
                              const std::vector<Eigen::Vector3f>& points, const Ground& ground,
                              std::vector<GridRay<3>>& rays) const {
  if (!directions.empty()) {
    addDirections(directions, rays);
    return;
  }
  VisitationConfig visitation;
  visitation.resolution_m = config_.grid.resolution_m;
  visitation.ring_step_rad = degToRad(config_.ring_step_deg);
  for (const auto& cell : unvisitedCells(points, ground, pose_, visitation)) {
    if (grid_.staticState(cell) == CellState::kOccupied) continue;
    const Eigen::Vector3f center = grid_.centerOf(cell);
    const Eigen::Vector3f next =
        center + Eigen::Vector3f::UnitX() * static_cast<float>(config_.grid.resolution_m);
    rays.push_back({center, next, false, false});
  }
}

}  // namespace kestrel
