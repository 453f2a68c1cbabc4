// SPDX-License-Identifier: BSD-3-Clause
#include "object_clusters.h"

#include <algorithm>
#include <utility>

#include "kestrel_slam/tracking/mean_shift.h"

namespace kestrel {
namespace {

/// Half of the returns that the narrowest object gives at this range.
std::size_t pointsNeeded(double range, const Visibility& visibility, const TrackerConfig& config) {
  const double spacing = range * visibility.beamStep();
  const double expected = spacing > 0.0 ? config.min_width_m / spacing : 0.0;
  return std::max(config.min_points, static_cast<std::size_t>(0.5 * expected));
}

ObjectCluster objectOf(std::vector<Eigen::Vector2d> points, const TrackerConfig& config) {
  ObjectCluster object;
  object.box = fitBox(points);
  object.observation.value = object.box.center;
  const double sigma = config.position_sigma + config.position_sigma_per_m * object.box.size.x();
  object.observation.noise = Eigen::Matrix2d::Identity() * sigma * sigma;
  object.points = std::move(points);
  return object;
}

}  // namespace

std::vector<ObjectCluster> findObjects(const std::vector<Eigen::Vector2d>& points,
                                       const Visibility& visibility, const TrackerConfig& config) {
  std::vector<ObjectCluster> objects;
  const auto clusters =
      joinConnected<2>(points, meanShift<2>(points, config.bandwidth_m), config.join_gap_m);
  for (const PointCluster<2>& cluster : clusters) {
    const double range = visibility.rangeOf(cluster.mode);
    if (cluster.points.size() < pointsNeeded(range, visibility, config)) continue;
    std::vector<Eigen::Vector2d> own;
    for (const std::size_t i : cluster.points) own.push_back(points[i]);
    objects.push_back(objectOf(std::move(own), config));
  }
  return objects;
}

}  // namespace kestrel
