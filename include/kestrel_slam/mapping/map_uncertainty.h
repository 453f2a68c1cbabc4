// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// How well the places of a map are known that was itself built from uncertain poses.
///
/// Every scan that entered the map keeps the covariance of its pose, and every wall the scan that
/// first saw it. A pose that is found from those walls is not known better than they are: to the
/// covariance of the match it adds the mean of theirs. Their errors are as one, for each scan was
/// placed by the walls of those before, so the mean of many is not smaller. The sum grows while the
/// vehicle explores and stops growing where it has been before.
class MapUncertainty {
 public:
  /// Of the next scan that enters the map: its pose (map_T_base) and the covariance of that (x, y,
  /// yaw in map, m² and rad²). To be called once for every update of the surface.
  void add(const Pose2& pose, const Eigen::Matrix3d& covariance);

  /// What the walls that a scan meets at `pose` say of it: the mean over their birth scans, each
  /// moved to `pose` as one rigid body with it. Along the direction that the scan constrains least
  /// it is that of the walls that do constrain it, where that is more. Zero where the scan meets no
  /// wall.
  Eigen::Matrix3d at(const SurfelField& surface, const Points& points, const Pose2& pose) const;

 private:
  struct Birth {
    Pose2 pose;
    Eigen::Matrix3d covariance;
  };
  std::vector<Birth> births_;
};

}  // namespace kestrel
