// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/lidar/ground.h"
#include "kestrel_slam/lidar/voxels.h"
#include "kestrel_slam/tracking/motion_grid.h"

namespace kestrel {

/// Makes the beams of a sweep for the grids.
class SweepRays {
 public:
  SweepRays(const MotionGrid<3>& grid, const CloudTrackerConfig& config,
            const Eigen::Isometry3d& map_T_lidar)
      : grid_(grid), config_(config), pose_(map_T_lidar) {}

  /// One beam for each voxel with points, the ground only as the end of free space.
  std::vector<GridRay<3>> measured(const Voxels& voxels, const Voxels& ground) const;
  /// Beams without return [Siew 2018, sec. V]: with known directions (in the frame of the lidar) as
  /// dummy points, without them by the visitation grid.
  void addUnanswered(const std::vector<Eigen::Vector3f>& directions,
                     const std::vector<Eigen::Vector3f>& points, const Ground& ground,
                     std::vector<GridRay<3>>& rays) const;

 private:
  GridRay<3> rayTo(const Eigen::Vector3f& end, float shorter) const;
  Eigen::Vector3f freeEnd(const Eigen::Vector3f& to) const;
  void addDirections(const std::vector<Eigen::Vector3f>& directions,
                     std::vector<GridRay<3>>& rays) const;

  const MotionGrid<3>& grid_;
  const CloudTrackerConfig& config_;
  const Eigen::Isometry3d& pose_;
};

}  // namespace kestrel
