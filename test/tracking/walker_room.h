// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

struct Disk {
  Eigen::Vector2d center;
  double radius;
};

/// Distance along the beam to a disk or to the walls of a room of 12 m x 12 m; infinite if nothing.
inline double castBeam(const Eigen::Vector2d& from, double bearing,
                       const std::vector<Disk>& disks) {
  const Eigen::Vector2d along(std::cos(bearing), std::sin(bearing));
  double nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    const double distance = (std::copysign(6.0, along(axis)) - from(axis)) / along(axis);
    if (distance > 0.0) nearest = std::min(nearest, distance);
  }
  for (const Disk& disk : disks) {
    const Eigen::Vector2d offset = disk.center - from;
    const double middle = along.dot(offset);
    const double miss2 = offset.squaredNorm() - middle * middle;
    if (middle <= 0.0 || miss2 > disk.radius * disk.radius) continue;
    nearest = std::min(nearest, middle - std::sqrt(disk.radius * disk.radius - miss2));
  }
  return nearest;
}

/// A laser with a beam for each half degree all around, 10 Hz, 1 cm noise.
class Room {
 public:
  PlanarScan scan(int number, const Pose2& pose, const std::vector<Disk>& disks) {
    PlanarScan result;
    result.stamp = result.time = 100.0 + 0.1 * number;
    for (int i = 0; i < 720; ++i) {
      const double bearing = i * kPi / 360.0;
      const double range =
          castBeam(pose.translation(), pose.yaw + bearing, disks) + 0.01 * random_.gaussian();
      const Eigen::Vector2d end(range * std::cos(bearing), range * std::sin(bearing));
      result.rays.push_back({Eigen::Vector2f::Zero(), end.cast<float>(), true});
    }
    return result;
  }

 private:
  Random random_{1};
};

}  // namespace kestrel
