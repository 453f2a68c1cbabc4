// SPDX-License-Identifier: BSD-3-Clause
#include "object_clusters.h"

#include <algorithm>
#include <cmath>
#include <iterator>
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

/// How far the middle of the object lies behind the middle of its visible points, m: the laser sees
/// only the near side. The object is taken as deep as it is wide, up to a limit.
double hiddenDepth(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& along,
                   const TrackerConfig& config) {
  const Eigen::Vector2d across(-along.y(), along.x());
  double near = along.dot(points.front()), far = near;
  double left = across.dot(points.front()), right = left;
  for (const Eigen::Vector2d& point : points) {
    near = std::min(near, along.dot(point));
    far = std::max(far, along.dot(point));
    left = std::min(left, across.dot(point));
    right = std::max(right, across.dot(point));
  }
  const double half_depth = std::min(0.5 * (right - left), config.half_depth_m);
  return std::max(0.0, half_depth - 0.5 * (far - near));
}

/// At a grazing angle, the returns of neighboring beams on a surface are this many beam spacings
/// apart.
constexpr double kGrazing = 6.0;

/// Beams are neighbors if the angle between them is at most this many beam steps. Between others,
/// beams are missing that gave no return.
constexpr double kNeighborSteps = 2.5;

/// What the beam beside the end of an object shows.
enum class Beside { kFarther, kNearer, kSame, kNothing };

bool areNeighbors(const GridRay<2>& a, const GridRay<2>& b, double beam_step) {
  const Eigen::Vector2f u = a.end - a.origin, v = b.end - b.origin;
  const double cross = static_cast<double>(u.x() * v.y() - u.y() * v.x());
  const double angle = std::atan2(std::abs(cross), static_cast<double>(u.dot(v)));
  return angle <= kNeighborSteps * beam_step;
}

/// `beside`: the next return, or a beam without return.
Beside besideOf(const GridRay<2>& end, const GridRay<2>& beside, const Visibility& visibility,
                const TrackerConfig& config) {
  const double range = visibility.rangeOf(end.end.cast<double>());
  const double gap = std::max(config.join_gap_m, kGrazing * visibility.beamStep() * range);
  const double farther = visibility.rangeOf(beside.end.cast<double>()) - range;
  if (!beside.hit || farther > gap) return Beside::kFarther;
  if (!areNeighbors(end, beside, visibility.beamStep())) return Beside::kNothing;
  return farther < -gap ? Beside::kNearer : Beside::kSame;
}

ObjectEnds endsOf(const PointCluster<2>& cluster, const std::vector<MovingPoint>& moving,
                  const std::vector<GridRay<2>>& rays, const Visibility& visibility,
                  const TrackerConfig& config) {
  std::size_t first = rays.size(), last = 0;
  for (const std::size_t i : cluster.points) {
    first = std::min(first, moving[i].ray);
    last = std::max(last, moving[i].ray);
  }
  if (first == 0 || last + 1 >= rays.size()) return ObjectEnds::kHidden;
  const Beside left = besideOf(rays[first], rays[first - 1], visibility, config);
  const Beside right = besideOf(rays[last], rays[last + 1], visibility, config);
  if (left == Beside::kSame || right == Beside::kSame) return ObjectEnds::kHidden;
  if (left == Beside::kFarther || right == Beside::kFarther) return ObjectEnds::kSeen;
  return left == Beside::kNearer && right == Beside::kNearer ? ObjectEnds::kHidden
                                                             : ObjectEnds::kUnknown;
}

ObjectCluster objectOf(std::vector<Eigen::Vector2d> points, const Visibility& visibility,
                       const TrackerConfig& config) {
  ObjectCluster object;
  object.box = fitBox(points);
  const Eigen::Vector2d along = visibility.directionTo(object.box.center);
  object.observation.value = object.box.center + hiddenDepth(points, along, config) * along;
  double sigma = config.position_sigma + config.position_sigma_per_m * object.box.size.x();
  if (visibility.isCut(points)) sigma += config.cut_sigma;
  object.observation.noise = Eigen::Matrix2d::Identity() * sigma * sigma;
  object.points = std::move(points);
  return object;
}

/// Where most of a cluster has come into free space, that is the object: the rest was perhaps
/// always there, as a post that the object uncovers. It would hold the middle back, and keep the
/// track when the object goes on.
std::vector<std::size_t> movingPart(const std::vector<std::size_t>& cluster,
                                    const std::vector<MovingPoint>& moving, std::size_t needed) {
  std::vector<std::size_t> come;
  come.reserve(cluster.size());
  std::copy_if(cluster.begin(), cluster.end(), std::back_inserter(come),
               [&](std::size_t i) { return moving[i].has_come; });
  return 2 * come.size() > cluster.size() && come.size() >= needed ? come : cluster;
}

PointCluster<2> clusterOf(std::vector<std::size_t> numbers,
                          const std::vector<Eigen::Vector2d>& points) {
  PointCluster<2> cluster{Eigen::Vector2d::Zero(), std::move(numbers)};
  for (const std::size_t i : cluster.points) cluster.mode += points[i];
  cluster.mode /= static_cast<double>(cluster.points.size());
  return cluster;
}

/// A thing beside the way of an object joins its cluster. The object is what is left without it,
/// if that has enough points to be seen as one.
void addParts(PointCluster<2>&& cluster, const std::vector<Eigen::Vector2d>& points,
              std::size_t needed, const StoodBefore& stood_before,
              std::vector<PointCluster<2>>& parts) {
  const std::vector<bool> stood =
      stood_before ? stood_before(points, cluster.points) : std::vector<bool>();
  std::vector<std::size_t> come, standing;
  for (std::size_t k = 0; k < stood.size(); ++k) {
    (stood[k] ? standing : come).push_back(cluster.points[k]);
  }
  if (standing.empty() || come.size() < needed) {
    parts.push_back(std::move(cluster));
    return;
  }
  parts.push_back(clusterOf(std::move(come), points));
  parts.push_back(clusterOf(std::move(standing), points));
}

}  // namespace

std::vector<ObjectCluster> findObjects(const std::vector<MovingPoint>& moving,
                                       const std::vector<GridRay<2>>& rays,
                                       const Visibility& visibility, const TrackerConfig& config,
                                       const StoodBefore& stood_before) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(moving.size());
  for (const MovingPoint& point : moving) points.push_back(point.position);
  const auto neededFor = [&](const PointCluster<2>& cluster) {
    return pointsNeeded(visibility.rangeOf(cluster.mode), visibility, config);
  };
  std::vector<PointCluster<2>> clusters;
  for (PointCluster<2>& joined :
       joinConnected<2>(points, meanShift<2>(points, config.bandwidth_m), config.join_gap_m)) {
    const std::size_t needed = neededFor(joined);
    addParts(std::move(joined), points, needed, stood_before, clusters);
  }
  std::vector<ObjectCluster> objects;
  for (const PointCluster<2>& cluster : clusters) {
    const std::size_t needed = neededFor(cluster);
    if (cluster.points.size() < needed) continue;
    std::vector<Eigen::Vector2d> own;
    own.reserve(cluster.points.size());
    for (const std::size_t i : movingPart(cluster.points, moving, needed)) {
      own.push_back(points[i]);
    }
    const auto free = std::count_if(cluster.points.begin(), cluster.points.end(),
                                    [&](std::size_t i) { return moving[i].was_free; });
    objects.push_back(objectOf(std::move(own), visibility, config));
    objects.back().ends = endsOf(cluster, moving, rays, visibility, config);
    objects.back().free_share =
        static_cast<double>(free) / static_cast<double>(cluster.points.size());
  }
  return objects;
}

}  // namespace kestrel
