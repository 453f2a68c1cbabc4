// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "kestrel_slam/lidar/cloud_tracker.h"
#include "kestrel_slam/lidar/ground.h"
#include "sweep_points.h"

namespace kestrel {

/// The points of a sweep in the map.
struct PlacedSweep {
  std::size_t cloud_size;
  const SweepPoints& usable;
  const Ground& ground;
  const std::vector<Eigen::Vector3f>& points;  ///< in the map
};

/// Marks the points of the cloud that lie within the boxes of shown tracks, and the ground. The
/// feet of an object lie in the layer that counts as ground: within a box, only what is very near
/// the plane is ground.
void markMovingPoints(const PlacedSweep& sweep, const std::vector<CloudTrack>& tracks,
                      std::vector<bool>& moving, std::vector<bool>& ground);

}  // namespace kestrel
