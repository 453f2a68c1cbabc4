// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <vector>

#include "kestrel_slam/tracking/object_box.h"
#include "kestrel_slam/tracking/phd_filter.h"
#include "kestrel_slam/tracking/tracker_config.h"
#include "visibility.h"

namespace kestrel {

/// A return of something that may move, in the frame of the grids.
struct MovingPoint {
  Eigen::Vector2d position;
  bool was_free = false;  ///< its cell was free before
  bool has_come = false;  ///< see MotionGrid::Result
  std::size_t ray = 0;    ///< its number in the scan
};

/// Whether the visible part is the whole width of the object.
enum class ObjectEnds {
  kHidden,   ///< it goes on, or something hides both ends: it may be a part of a wall, and its
             ///< middle may move while it stands
  kUnknown,  ///< the beams beside it gave no return, as those on dark parts of a wall may do
  kSeen      ///< at one end at least, the laser sees something farther beside it
};

/// A cluster of moving points: an observation of the PHD filter.
struct ObjectCluster {
  Observation<2> observation;  ///< of the middle
  OrientedBox box;
  std::vector<Eigen::Vector2d> points;  ///< without those beside it that were perhaps always there
  /// Share of all returns of the cluster in space that was free before: something has come here.
  double free_share = 0.0;
  ObjectEnds ends = ObjectEnds::kHidden;
};

/// Of each of the points with these numbers, which are a cluster: did something stand there before
/// what moves came there? Empty: nowhere.
using StoodBefore = std::function<std::vector<bool>(const std::vector<Eigen::Vector2d>& points,
                                                    const std::vector<std::size_t>& numbers)>;

/// Clusters of the points, without those that have too few points for their range. What stood there
/// before is an object of its own.
std::vector<ObjectCluster> findObjects(const std::vector<MovingPoint>& points,
                                       const std::vector<GridRay<2>>& rays,
                                       const Visibility& visibility, const TrackerConfig& config,
                                       const StoodBefore& stood_before = {});

}  // namespace kestrel
