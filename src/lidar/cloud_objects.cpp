// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_objects.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/tracking/mean_shift.h"

namespace kestrel {
namespace {

using Plane = std::vector<Eigen::Vector2d>;

constexpr std::size_t kBoxPoints = 150;  ///< of an object, to which the box is fitted
constexpr double kVehicleSide = 1.3;     ///< m; nothing but a vehicle has a side as long as this
constexpr double kPersonDepth = 0.3;     ///< m
// The least size of a vehicle, m: of a longer one more was seen, or will be seen.
constexpr double kVehicleLength = 4.2, kVehicleWidth = 1.7;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
  /// Makes it at least this long: the side that faces the lidar is seen, the other is not.
  void extendTo(double length, double lidar) {
    const double missing = length - size();
    if (missing <= 0.0) return;
    if (lidar < low) {
      high += missing;
    } else if (lidar > high) {
      low -= missing;
    }
  }
};

Plane planeOf(const std::vector<MovingVoxel>& voxels, const std::vector<std::size_t>& own) {
  std::size_t count = 0;
  for (const std::size_t v : own) count += voxels[v].points.size();
  const std::size_t step = (count + kBoxPoints - 1) / kBoxPoints;
  Plane plane;
  std::size_t i = 0;
  for (const std::size_t v : own) {
    for (const Eigen::Vector3f& point : voxels[v].points) {
      if (i++ % step == 0) plane.emplace_back(point.head<2>().cast<double>());
    }
  }
  return plane;
}

/// Sets box and extents: a box along `yaw` that is completed behind the visible sides.
void setBox(const Plane& plane, double yaw, const KnownShape& known, bool yaw_is_known,
            const Eigen::Vector2d& lidar, CloudObject& object) {
  const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw)), v(-u.y(), u.x());
  Extent along, across;
  for (const Eigen::Vector2d& point : plane) {
    along.add(u.dot(point));
    across.add(v.dot(point));
  }
  object.length = along.size();
  object.width = across.size();
  const bool is_vehicle =
      std::max({object.length, object.width, known.length, known.width}) > kVehicleSide;
  // Without a motion, the longer visible side may be the rear of a vehicle.
  const double least_length = !is_vehicle ? kPersonDepth : yaw_is_known ? kVehicleLength : 0.0;
  along.extendTo(std::max(known.length, least_length), u.dot(lidar));
  across.extendTo(std::max(known.width, is_vehicle ? kVehicleWidth : kPersonDepth), v.dot(lidar));
  object.box.center = along.middle() * u + across.middle() * v;
  object.box.size = {along.size(), across.size()};
  object.box.yaw = normalizeAngle(yaw);
}

CloudObject objectOf(const std::vector<MovingVoxel>& voxels, std::vector<std::size_t> own,
                     const Eigen::Vector3d& lidar, const CloudTrackerConfig& config,
                     const std::optional<KnownShape>& known) {
  CloudObject object;
  Extent height;
  for (const std::size_t v : own) {
    for (const Eigen::Vector3f& point : voxels[v].points) {
      height.add(static_cast<double>(point.z()));
    }
  }
  object.bottom = height.low;
  object.top = height.high;
  const Plane plane = planeOf(voxels, own);
  const bool yaw_is_known = known && known->yaw;
  setBox(plane, yaw_is_known ? *known->yaw : fitBox(plane).yaw, known.value_or(KnownShape()),
         yaw_is_known, lidar.head<2>(), object);
  object.observation.value << object.box.center, height.middle();
  const double sigma =
      config.position_sigma + config.position_sigma_per_m * object.box.size.maxCoeff();
  object.observation.noise = Eigen::Matrix3d::Identity() * sigma * sigma;
  object.voxels = std::move(own);
  return object;
}

}  // namespace

/// In the plane, because on the ground nothing moves above something else, and because the gaps
/// between the rings of a lidar are much wider than those along a ring.
std::vector<CloudObject> findCloudObjects(
    const std::vector<MovingVoxel>& voxels, const Eigen::Vector3d& lidar,
    const CloudTrackerConfig& config,
    const std::function<std::optional<KnownShape>(const Eigen::Vector2d&)>& known) {
  Plane centers;
  for (const MovingVoxel& voxel : voxels) centers.emplace_back(voxel.centroid.head<2>());
  auto clusters =
      joinConnected<2>(centers, meanShift<2>(centers, config.bandwidth_m), config.join_gap_m);
  std::vector<CloudObject> objects;
  for (PointCluster<2>& cluster : clusters) {
    std::size_t points = 0;
    double bottom = std::numeric_limits<double>::infinity();
    for (const std::size_t v : cluster.points) {
      points += voxels[v].points.size();
      bottom = std::min(bottom, voxels[v].centroid.z());
    }
    if (points < config.min_points || bottom > lidar.z() + config.max_height_m) continue;
    objects.push_back(
        objectOf(voxels, std::move(cluster.points), lidar, config, known(cluster.mode)));
  }
  return objects;
}

}  // namespace kestrel
