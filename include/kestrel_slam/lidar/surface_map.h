// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {

/// A voxel of the static map, as the ICP needs it.
struct SurfaceCell {
  Eigen::Vector3f mean;    ///< centroid of all its points
  Eigen::Vector3f normal;  ///< zero if the points do not form a plane
  float thickness = 0.0F;  ///< of the plane: standard deviation of its points, m
  /// How far the plane may be turned: the direction in it that would rise or fall the most, times
  /// the sine of the angle.
  Eigen::Vector3f tilt = Eigen::Vector3f::Zero();
};

/// Static map for localization: a hashed voxel grid that keeps the centroid and the spread of the
/// points of every voxel [Siew 2018, sec. VI-B]. Grows without limits in space; what is far away is
/// forgotten by forgetFar().
class SurfaceMap {
 public:
  explicit SurfaceMap(double resolution = 0.5) : resolution_(resolution) {}

  /// Adds the points of voxels of this resolution, seen by a lidar at `lidar` (m, in the map).
  /// `ground`: for each voxel the normal of the ground that it belongs to, or zero; empty: no
  /// ground.
  void add(const Voxels& voxels, const Eigen::Vector3d& lidar,
           const std::vector<Eigen::Vector3f>& ground = {});
  /// Removes the cells that are farther than `radius` from the position, m.
  void forgetFar(const Eigen::Vector3d& position, double radius);

  /// True if the cell of the point or one of its neighbors has points.
  bool isNear(const Eigen::Vector3f& point) const;
  const std::vector<SurfaceCell>& cells() const { return surfaces_; }
  double resolution() const { return resolution_; }
  std::size_t memoryBytes() const;

 private:
  struct Cell {
    GridIndex<3> index;
    PointSums sums;
    Eigen::Vector3d beams;         ///< sum of the directions to the points
    double count_of_normal = 0.0;  ///< number of points from which the normal was computed
  };

  void update(std::size_t number, const Eigen::Vector3f& ground);
  std::vector<std::uint32_t> around(const GridIndex<3>& index) const;
  Cell aroundOf(const Cell& cell) const;

  double resolution_;
  VoxelTable table_;
  std::vector<Cell> cells_;
  std::vector<SurfaceCell> surfaces_;  ///< of the same cells
};

}  // namespace kestrel
