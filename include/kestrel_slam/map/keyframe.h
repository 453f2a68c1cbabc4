// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/compact_scan.h"

namespace kestrel {

/// A scan that was inserted into a submap, with all that is needed to insert it again. It never
/// changes after it was made, and is shared by all who use it.
struct Keyframe {
  std::uint64_t id = 0;
  double stamp = 0.0;  ///< as recorded, s; identifies the scan, see PlanarScan
  double time = 0.0;   ///< reference time, s
  Pose2 submap_T_base;
  /// Of submap_T_base, in the axes of the submap: (x, y, yaw), m², m rad, rad².
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Of the motion since the previous keyframe, in the tangent space of that motion.
  Eigen::Matrix3d motion_covariance = Eigen::Matrix3d::Zero();
  /// See OccupancyGrid::insert.
  bool new_view = false;
  ScanHeight height;
  CompactScan scan;

  /// The scan, ready to be inserted.
  PlanarScan planarScan() const;
  std::size_t memoryBytes() const { return sizeof *this - sizeof scan + scan.memoryBytes(); }
};

using KeyframePtr = std::shared_ptr<const Keyframe>;

}  // namespace kestrel
