// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_objects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/tracking/mean_shift.h"

namespace kestrel {
namespace {

using Plane = std::vector<Eigen::Vector2d>;

constexpr std::size_t kBoxPoints = 150;  ///< of an object, to which the box is fitted
constexpr double kVehicleSide = 1.3;     ///< m; nothing but a vehicle has a side as long as this
constexpr double kLongestBicycle = 2.5;
constexpr double kPersonDepth = 0.3;  ///< m
constexpr int kSamples = 5;           ///< along each side of a box
// The least size of a vehicle, m: of a longer one more was seen, or will be seen.
constexpr double kVehicleLength = 4.2, kVehicleWidth = 1.7;

// A vehicle whose top is so much above the lidar is a truck or a bus, m.
constexpr double kTruck = 0.7, kTruckLength = 9.0;

/// What lies behind the visible end of a vehicle is a part of it up to this length, m, and this far
/// beside it.
constexpr double kLongestVehicle = 6.0, kLongestTruck = 12.0, kBeside = 0.3;
/// rad; in a smaller gap between two directions there are hardly any beams.
constexpr double kBearingGap = 0.5 * kPi / 180.0;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool contains(double value) const { return low <= value && value <= high; }
  double size() const { return high - low; }
  double gapTo(const Extent& other) const { return std::max(low - other.high, other.low - high); }
  double middle() const { return 0.5 * (low + high); }
  double at(double share) const { return low + share * size(); }
  Extent widenedTo(double length) const {
    const double missing = 0.5 * std::max(0.0, length - size());
    return {low - missing, high + missing};
  }
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

/// A box seen from above.
struct Area {
  Extent along, across;
};

/// True if beams pass through most of the part of an area where nothing was seen, at this height:
/// it is not hidden behind the visible part, so nothing is there.
bool isPassed(const Area& area, const Area& seen, const Eigen::Vector2d& u, double z,
              const LidarView& view) {
  const Eigen::Vector2d v(-u.y(), u.x());
  int passed = 0, hidden = 0;
  for (int i = 0; i < kSamples; ++i) {
    for (int j = 0; j < kSamples; ++j) {
      const double x = area.along.at((i + 0.5) / kSamples);
      const double y = area.across.at((j + 0.5) / kSamples);
      if (seen.along.contains(x) && seen.across.contains(y)) continue;
      const Eigen::Vector2d place = x * u + y * v;
      (view.isPassed({place.x(), place.y(), z}) ? passed : hidden) += 1;
    }
  }
  return passed > hidden;
}

/// Sets box and extents: a box along `yaw` that is completed behind the visible sides. False if
/// beams refute the shape that is known.
bool setBox(const Plane& plane, double yaw, const KnownShape& known, bool yaw_is_known,
            const LidarView& view, CloudObject& object) {
  const Eigen::Vector3d& lidar = view.lidar();
  const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw)), v(-u.y(), u.x());
  Extent along, across;
  for (const Eigen::Vector2d& point : plane) {
    along.add(u.dot(point));
    across.add(v.dot(point));
  }
  const Area seen{along, across};
  object.length = along.size();
  object.width = across.size();
  const double length = std::max(object.length, known.length);
  const double width = std::max(object.width, known.width);
  // A bicycle is long in the direction of its motion, but not wide.
  const bool is_vehicle =
      width > kVehicleSide || length > (yaw_is_known ? kLongestBicycle : kVehicleSide);
  // Without a motion, the longer visible side may be the rear of a vehicle.
  const double vehicle_length = object.top > lidar.z() + kTruck ? kTruckLength : kVehicleLength;
  const double least_length = !is_vehicle ? kPersonDepth : yaw_is_known ? vehicle_length : 0.0;
  along.extendTo(std::max(known.length, least_length), u.dot(lidar.head<2>()));
  across.extendTo(std::max(known.width, is_vehicle ? kVehicleWidth : kPersonDepth),
                  v.dot(lidar.head<2>()));
  object.box.center = along.middle() * u + across.middle() * v;
  object.box.size = {along.size(), across.size()};
  object.box.yaw = normalizeAngle(yaw);
  object.is_along_motion = is_vehicle && yaw_is_known;
  const bool has_shape = known.length > 0.0 || known.width > 0.0;
  const Area claimed{along.widenedTo(known.length), across.widenedTo(known.width)};
  return !has_shape || !isPassed(claimed, seen, u, 0.5 * (object.bottom + object.top), view);
}

CloudObject objectOf(const std::vector<MovingVoxel>& voxels, std::vector<std::size_t> own,
                     const LidarView& view, const CloudTrackerConfig& config,
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
  const double yaw = yaw_is_known ? *known->yaw : fitBox(plane).yaw;
  object.refutes_shape =
      !setBox(plane, yaw, known.value_or(KnownShape()), yaw_is_known, view, object);
  if (object.refutes_shape) setBox(plane, yaw, KnownShape(), yaw_is_known, view, object);
  object.observation.value << object.box.center, height.middle();
  const double sigma =
      config.position_sigma + config.position_sigma_per_m * object.box.size.maxCoeff();
  object.observation.noise = Eigen::Matrix3d::Identity() * sigma * sigma;
  object.voxels = std::move(own);
  return object;
}

using Known = std::function<std::optional<KnownShape>(const Eigen::Vector2d&)>;

/// The tracks in a cluster. Of tracks that overlap, the largest: they follow one object.
std::vector<KnownShape> tracksIn(const std::vector<std::size_t>& cluster, const Plane& centers,
                                 const Known& known) {
  std::map<long, KnownShape> found;
  for (const std::size_t v : cluster) {
    const auto shape = known(centers[v]);
    if (shape && shape->track > 0) found.emplace(shape->track, *shape);
  }
  std::vector<KnownShape> sorted, kept;
  for (const auto& [track, shape] : found) sorted.push_back(shape);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.reach > b.reach; });
  for (const KnownShape& shape : sorted) {
    const bool overlaps = std::any_of(kept.begin(), kept.end(), [&](const KnownShape& other) {
      return (other.center - shape.center).norm() < other.reach + 0.5 * shape.reach;
    });
    if (!overlaps) kept.push_back(shape);
  }
  return kept;
}

/// Divides a cluster between the tracks in it: a voxel belongs to the track whose border is
/// nearest.
std::vector<std::vector<std::size_t>> divided(const std::vector<std::size_t>& cluster,
                                              const Plane& centers, const Known& known) {
  const std::vector<KnownShape> tracks = tracksIn(cluster, centers, known);
  if (tracks.size() < 2) return {cluster};
  std::vector<std::vector<std::size_t>> parts(tracks.size());
  for (const std::size_t v : cluster) {
    const auto distanceTo = [&](const KnownShape& shape) {
      return (shape.center - centers[v]).norm() - shape.reach;
    };
    const auto nearest = std::min_element(
        tracks.begin(), tracks.end(),
        [&](const auto& a, const auto& b) { return distanceTo(a) < distanceTo(b); });
    parts[static_cast<std::size_t>(nearest - tracks.begin())].push_back(v);
  }
  return parts;
}

Eigen::Vector2d middleOf(const std::vector<std::size_t>& own, const Plane& centers) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const std::size_t v : own) sum += centers[v];
  return sum / static_cast<double>(own.size());
}

/// True if there are enough points, and not too high.
bool isObject(const std::vector<std::size_t>& own, const std::vector<MovingVoxel>& voxels,
              const Eigen::Vector3d& lidar, const CloudTrackerConfig& config) {
  std::size_t points = 0;
  double bottom = std::numeric_limits<double>::infinity();
  for (const std::size_t v : own) {
    points += voxels[v].points.size();
    bottom = std::min(bottom, voxels[v].centroid.z());
  }
  return points >= config.min_points && bottom <= lidar.z() + config.max_height_m;
}

/// Directions from the lidar in which voxels lie, rad, counted from the direction `ahead`.
Extent bearingsOf(const std::vector<std::size_t>& own, const Plane& centers,
                  const Eigen::Vector2d& lidar, const Eigen::Vector2d& ahead) {
  Extent bearings;
  for (const std::size_t v : own) {
    const Eigen::Vector2d to = centers[v] - lidar;
    bearings.add(std::atan2(ahead.x() * to.y() - ahead.y() * to.x(), ahead.dot(to)));
  }
  return bearings;
}

/// Forms objects, and joins those that cover each other.
class ObjectBuilder {
 public:
  ObjectBuilder(const std::vector<MovingVoxel>& voxels, const Plane& centers, const LidarView& view,
                const CloudTrackerConfig& config, const Known& known)
      : voxels_(voxels), centers_(centers), view_(view), config_(config), known_(known) {}

  void add(std::vector<std::size_t> own) {
    CloudObject object = build(std::move(own));
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      if (!areOne(object, objects_[i])) continue;
      std::vector<std::size_t> both = std::move(object.voxels);
      both.insert(both.end(), objects_[i].voxels.begin(), objects_[i].voxels.end());
      objects_.erase(objects_.begin() + static_cast<std::ptrdiff_t>(i));
      add(std::move(both));
      return;
    }
    objects_.push_back(std::move(object));
  }

  std::vector<CloudObject> finish() {
    objects_.erase(std::remove_if(objects_.begin(), objects_.end(),
                                  [this](const CloudObject& object) {
                                    return !isObject(object.voxels, voxels_, view_.lidar(),
                                                     config_);
                                  }),
                   objects_.end());
    return std::move(objects_);
  }

 private:
  /// The middle of the visible points of one lies in the box of the other: a lidar sees the hull
  /// and the cabin of a vehicle with a gap in between. (The box of a part says less: what was
  /// completed may be beside the object.)
  bool areOne(const CloudObject& a, const CloudObject& b) const {
    return a.box.contains(middleOf(b.voxels, centers_)) ||
           b.box.contains(middleOf(a.voxels, centers_)) || continues(a, b) || continues(b, a);
  }

  /// True if `part` lies behind the visible end of a vehicle, and the lidar sees no gap between
  /// them. Along the side of a vehicle that comes or goes, the returns are more than a meter apart.
  bool continues(const CloudObject& vehicle, const CloudObject& part) const {
    if (!vehicle.is_along_motion) return false;
    const Eigen::Vector2d u(std::cos(vehicle.box.yaw), std::sin(vehicle.box.yaw));
    const Eigen::Vector2d lidar = view_.lidar().head<2>(), ahead = vehicle.box.center - lidar;
    const Eigen::Vector2d away = u.dot(ahead) < 0.0 ? (-u).eval() : u;
    Extent behind, beside;
    for (const std::size_t i : part.voxels) {
      const Eigen::Vector2d to = centers_[i] - vehicle.box.center;
      behind.add(away.dot(to) + 0.5 * vehicle.box.size.x());
      beside.add(u.x() * to.y() - u.y() * to.x());
    }
    const bool is_truck = vehicle.top > view_.lidar().z() + kTruck;
    return behind.middle() > 0.0 && behind.high < (is_truck ? kLongestTruck : kLongestVehicle) &&
           std::abs(beside.middle()) < 0.5 * vehicle.box.size.y() + kBeside &&
           bearingsOf(vehicle.voxels, centers_, lidar, ahead)
                   .gapTo(bearingsOf(part.voxels, centers_, lidar, ahead)) < kBearingGap;
  }

  CloudObject build(std::vector<std::size_t> own) const {
    const auto shape = known_(middleOf(own, centers_));
    return objectOf(voxels_, std::move(own), view_, config_, shape);
  }

  const std::vector<MovingVoxel>& voxels_;
  const Plane& centers_;
  const LidarView& view_;
  const CloudTrackerConfig& config_;
  const Known& known_;
  std::vector<CloudObject> objects_;
};

}  // namespace

/// In the plane, because on the ground nothing moves above something else, and because the gaps
/// between the rings of a lidar are much wider than those along a ring.
std::vector<CloudObject> findCloudObjects(const std::vector<MovingVoxel>& voxels,
                                          const LidarView& view, const CloudTrackerConfig& config,
                                          const Known& known) {
  Plane centers;
  for (const MovingVoxel& voxel : voxels) centers.emplace_back(voxel.centroid.head<2>());
  const auto clusters =
      joinConnected<2>(centers, meanShift<2>(centers, config.bandwidth_m), config.join_gap_m);
  ObjectBuilder builder(voxels, centers, view, config, known);
  for (const PointCluster<2>& cluster : clusters) {
    for (std::vector<std::size_t>& own : divided(cluster.points, centers, known)) {
      if (!own.empty()) builder.add(std::move(own));
    }
  }
  return builder.finish();
}

}  // namespace kestrel
