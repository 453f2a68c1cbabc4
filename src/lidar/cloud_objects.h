// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker_config.h"
#include "kestrel_slam/tracking/object_box.h"
#include "kestrel_slam/tracking/phd_filter.h"
#include "lidar_view.h"

namespace kestrel {

/// A voxel with moving points.
struct MovingVoxel {
  std::uint32_t number = 0;  ///< of the voxel in the sweep
  Eigen::Vector3d centroid;
  std::vector<Eigen::Vector3f> points;
  bool was_free = false;  ///< known as free before this sweep
  bool has_come = false;  ///< see MotionGrid
};

/// Points that move together.
struct CloudObject {
  Observation<3> observation;        ///< middle of the whole object
  OrientedBox box;                   ///< of the whole object, seen from above
  double length = 0.0, width = 0.0;  ///< visible extents along and across the box, m
  double bottom = 0.0, top = 0.0;    ///< of the visible points, m
  bool refutes_shape = false;        ///< it is smaller than what is known of its track
  bool is_along_motion = false;      ///< a vehicle whose box is along its known motion
  std::vector<std::size_t> voxels;   ///< indices of MovingVoxel
};

/// What is known of the object at a place from its track.
struct KnownShape {
  long track = 0;  ///< its id; 0: it has not moved yet
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double reach = 0.0;                ///< half of its longer side, m
  double length = 0.0, width = 0.0;  ///< largest extents that were seen, m
  std::optional<double> yaw;         ///< of its motion, if it moves
};

/// Clusters of the moving voxels, with boxes. `known`: the track at a place, if there is one. A
/// cluster in which several tracks lie is divided between them.
std::vector<CloudObject> findCloudObjects(
    const std::vector<MovingVoxel>& voxels, const LidarView& view, const CloudTrackerConfig& config,
    const std::function<std::optional<KnownShape>(const Eigen::Vector2d&)>& known);

}  // namespace kestrel
