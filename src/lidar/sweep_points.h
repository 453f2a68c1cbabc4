// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// The usable points of a sweep, in the frame of the lidar at the stamp of the cloud.
struct SweepPoints {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::size_t> number;  ///< of each point in the cloud
  bool thinned = false;             ///< the cloud has more points than the limit
};

/// Keeps the finite points within the limits of the range (m), at most `max_points`. `motion`: of
/// the lidar in one second; points with a time are moved to where they would be seen at the stamp.
SweepPoints usablePoints(const PointCloud& cloud, double min_range, double max_range,
                         std::size_t max_points, const Eigen::Matrix<double, 6, 1>& motion);

/// Motion in one second (translation, rotation vector) that makes `change` in `seconds`.
Eigen::Matrix<double, 6, 1> rateOf(const Eigen::Isometry3d& change, double seconds);
/// The change of the pose after `seconds` of a motion.
Eigen::Isometry3d changeOf(const Eigen::Matrix<double, 6, 1>& rate, double seconds);

}  // namespace kestrel
