// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/OccupancyGrid.h>

#include <Eigen/Geometry>

#include "kestrel_slam/Track.h"
#include "kestrel_slam/lidar/cloud_tracker.h"

namespace kestrel {

/// A track of a 3D lidar in the frame to which `frame_T_map` maps. Both frames have z up.
kestrel_slam::Track toMessage(const CloudTrack& track, const Eigen::Isometry3d& frame_T_map);

/// The dynamic grid within `radius` (m) of `center`, seen from above: the largest probability of a
/// column, 0 to 100; -1 where nothing is known. The caller sets the header.
nav_msgs::OccupancyGrid toMessage(const MotionGrid<3>& grid, const Eigen::Vector3d& center,
                                  double radius, const Eigen::Isometry3d& frame_T_map);

}  // namespace kestrel
