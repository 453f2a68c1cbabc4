// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/tracking/object_box.h"
#include "kestrel_slam/tracking/phd_filter.h"
#include "kestrel_slam/tracking/tracker_config.h"
#include "visibility.h"

namespace kestrel {

/// A cluster of moving points: an observation of the PHD filter.
struct ObjectCluster {
  Observation<2> observation;  ///< of the middle
  OrientedBox box;
  std::vector<Eigen::Vector2d> points;
};

/// Clusters of the points, without those that have too few points for their range.
std::vector<ObjectCluster> findObjects(const std::vector<Eigen::Vector2d>& points,
                                       const Visibility& visibility, const TrackerConfig& config);

}  // namespace kestrel
