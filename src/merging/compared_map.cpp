// SPDX-License-Identifier: BSD-3-Clause
#include "compared_map.h"

#include <algorithm>
#include <utility>

namespace kestrel {
namespace {

constexpr float kReachM = 10.0F;  ///< what is compared

/// The scan up to a distance at which errors of the yaw do not move a wall far.
PlanarScan nearPart(PlanarScan scan) {
  for (PlanarRay& ray : scan.rays) {
    const Eigen::Vector2f along = ray.end - ray.origin;
    const float length = along.norm();
    if (length <= kReachM) continue;
    ray.end = ray.origin + along * (kReachM / length);
    ray.hit = false;
  }
  return scan;
}

/// What the scan shows to be free, up to near its hits.
PlanarScan freePart(PlanarScan scan) {
  constexpr auto kNear = static_cast<float>(kSameWallM);
  const auto saysNothing = [](const PlanarRay& ray) {
    return ray.no_return || ray.presumed || (ray.end - ray.origin).norm() <= kNear;
  };
  scan.rays.erase(std::remove_if(scan.rays.begin(), scan.rays.end(), saysNothing), scan.rays.end());
  for (PlanarRay& ray : scan.rays) {
    if (ray.hit) ray.end -= kNear * (ray.end - ray.origin).normalized();
    ray.hit = false;
  }
  return scan;
}

OccupancyGridConfig comparedGrid() {
  OccupancyGridConfig config;
  config.resolution_m = kComparedCellM;
  return config;
}

}  // namespace

template <typename Visit>
void ComparedMap::forEachScan(Visit visit) const {
  for (std::size_t i = part_.first; i < part_.last; ++i) {
    if (used_[i]) visit(nearPart(joint_.keyframes()[i].keyframe->planarScan()), poses_[i].pose);
  }
}

ComparedMap::ComparedMap(const JointMap& joint, const std::vector<PoseVertex>& poses,
                         const std::vector<bool>& used, std::size_t part)
    : joint_(joint), poses_(poses), used_(used), part_(joint.parts()[part]), grid_(comparedGrid()) {
  bool has_heights = false;
  forEachScan([&](const PlanarScan& scan, const Pose2& pose) {
    grid_.insert(scan, pose);
    has_heights = has_heights || scan.height.isKnown();
  });
  if (!has_heights) return;
  passed_.emplace(comparedGrid());
  forEachScan([&](PlanarScan scan, const Pose2& pose) {
    passed_->insert(freePart(std::move(scan)), pose);
  });
}

std::vector<Sightings> ComparedMap::sightings(const std::vector<ComparedPoint>& points) const {
  SightingCollector collector(points, kComparedCellM, kSameWallM);
  forEachScan([&](PlanarScan scan, const Pose2& pose) { collector.add(std::move(scan), pose); });
  return collector.sightings();
}

}  // namespace kestrel
