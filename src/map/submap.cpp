// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/submap.h"

#include <atomic>
#include <memory>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {
namespace {

constexpr double kMegabyte = 1e6;

std::uint64_t newRevision() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

}  // namespace

Submap::Submap(const OccupancyGridConfig& config, const SubmapOptions& options)
    : options_(options),
      budget_(std::make_shared<MemoryBudget>(
          static_cast<std::size_t>(config.memory_limit_mb * kMegabyte))),
      grid_(config, budget_),
      surface_(static_cast<float>(config.resolution_m), budget_),
      revision_(newRevision()) {}

bool Submap::insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view,
                    std::uint32_t number) {
  const OccupancyGrid::Changes& changes =
      options_.stitching ? grid_.insert(stitched(scan, map_T_base), map_T_base, new_view)
                         : grid_.insert(scan, map_T_base, new_view);
  return update(changes, scan, map_T_base, number);
}

bool Submap::insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view,
                    std::uint32_t number, const FreeCells& free) {
  return update(grid_.insert(scan, map_T_base, free, new_view), scan, map_T_base, number);
}

/// After an insertion into the grid.
bool Submap::update(const OccupancyGrid::Changes& changes, const PlanarScan& scan,
                    const Pose2& map_T_base, std::uint32_t number) {
  const bool surface_complete = surface_.update(grid_, changes, number);
  keep(scan, map_T_base);
  ++scans_;
  revision_ = newRevision();
  const bool complete = surface_complete && !changes.full;
  full_ |= !complete;
  return complete;
}

/// The scan with its associated hits marked as known. Their beams end at the associated point, so
/// that a beam that ends slightly behind a wall does not clear it.
PlanarScan Submap::stitched(const PlanarScan& scan, const Pose2& map_T_base) const {
  PlanarScan result = scan;
  const Pose2 base_T_map = map_T_base.inverse();
  const float reach = surface_.resolution();  // a point in the next cell belongs to the same wall
  for (PlanarRay& ray : result.rays) {
    if (!ray.hit) continue;
    const Eigen::Vector2f point = (map_T_base * ray.end.cast<double>()).cast<float>();
    const Surfel* surfel = surface_.nearest(point);
    if (surfel == nullptr || (point - surfel->mean).norm() > reach) continue;
    ray.known = true;
    ray.end = (base_T_map * surfel->mean.cast<double>()).cast<float>();
  }
  return result;
}

void Submap::keep(const PlanarScan& scan, const Pose2& map_T_base) {
  if (options_.kept_scans == 0) return;
  if (keyframes_.size() >= options_.kept_scans) keyframes_.pop_front();
  keyframes_.push_back({map_T_base, hitsOf(scan)});
}

void Submap::clear() {
  grid_.clear();
  surface_.clear();
  keyframes_.clear();
  scans_ = 0;
  full_ = false;
  revision_ = newRevision();
}

std::size_t Submap::memoryBytes() const {
  std::size_t bytes = grid_.memoryBytes() + surface_.memoryBytes();
  for (const InsertedScan& keyframe : keyframes_) {
    bytes += sizeof(InsertedScan) + keyframe.hits.capacity() * sizeof(Eigen::Vector2f);
  }
  return bytes;
}

}  // namespace kestrel
