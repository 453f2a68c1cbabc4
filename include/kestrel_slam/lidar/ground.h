// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "kestrel_slam/lidar/voxels.h"

namespace kestrel {

/// Parameters of the removal of the ground [Siew 2018, sec. V].
struct GroundConfig {
  double lowest_share = 0.4;    ///< of the points of a quadrant, to which the plane is fitted
  double height_m = 0.254;      ///< points within 10 inches of the plane are ground
  double max_slope_deg = 30.0;  ///< a steeper plane is a wall; the quadrant keeps its points
  double inlier_m = 0.1;        ///< distance from the plane in RANSAC
  double reach_m = 40.0;        ///< points beyond do not take part in the fit: the ground bends
};

/// Height above the plane: normal · point + offset.
struct GroundPlane {
  Eigen::Vector3f normal;
  float offset;

  float heightOf(const Eigen::Vector3f& point) const { return normal.dot(point) + offset; }
};

/// The ground around a lidar, in the frame of the lidar.
struct Ground {
  std::array<std::optional<GroundPlane>, 4> planes;  ///< of the four quadrants
  std::vector<bool> is_ground;                       ///< of each point

  /// The plane under the point; nothing if its quadrant has none.
  const std::optional<GroundPlane>& planeAt(const Eigen::Vector3f& point) const;
};

/// Fits a plane to the lowest points of each quadrant by RANSAC and marks the points near it.
/// Deterministic. Points must be finite.
Ground findGround(const std::vector<Eigen::Vector3f>& points,
                  const GroundConfig& config = GroundConfig());

/// For each voxel of the points that has nothing but ground: the normal of the ground, in the frame
/// of the voxels. Zero for others, and if fewer than three quadrants have a ground. A ring on the
/// ground is a line, and does not show its slope.
std::vector<Eigen::Vector3f> groundNormals(const Ground& ground, const Voxels& voxels,
                                           const Eigen::Isometry3d& frame_T_lidar);

}  // namespace kestrel
