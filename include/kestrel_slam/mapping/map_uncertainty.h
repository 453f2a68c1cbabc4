// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/surfel_field.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// Uncertainty of the places in a map that is built from uncertain poses.
///
/// For every inserted scan, the covariance of its pose is stored. For every wall, the scan that
/// first saw it is known. A pose that is matched to these walls cannot be more certain than the
/// walls. Therefore the mean of their covariances is added to the match covariance. The errors of
/// the walls are correlated, because each scan was placed relative to the walls of earlier scans;
/// so the covariance of the mean is not smaller. The sum grows while the vehicle explores, and does
/// not grow in known places.
class MapUncertainty {
 public:
  /// Adds the next inserted scan: its pose (map_T_base) and the covariance of (x, y, yaw) in the
  /// map frame, m² and rad². To be called once per update of the surface.
  void add(const Pose2& pose, const Eigen::Matrix3d& covariance);

  /// Map covariance of a scan at `pose`: the mean over the walls that it hits, each covariance
  /// transported to `pose` as on a rigid body. Along the weakest direction of the scan, the
  /// covariance of the walls that constrain this direction is used if it is larger. Zero if the
  /// scan hits no wall. `points` in the base frame, m; the result is of (x, y, yaw) in the map
  /// frame, m² and rad².
  Eigen::Matrix3d at(const SurfelField& surface, const Points& points, const Pose2& pose) const;

 private:
  struct InsertedScan {
    Pose2 pose;
    Eigen::Matrix3d covariance;
  };
  std::vector<InsertedScan> scans_;  ///< by Surfel::birth
};

}  // namespace kestrel
