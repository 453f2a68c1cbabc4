// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

#include "kestrel_slam/geometry/pose_covariance.h"
#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// What a graph says about the newest poses of the mapper, which are in the local frame.
struct GraphCorrection {
  /// A keyframe whose pose in map has a covariance from the graph.
  struct Known {
    GaussianPose2 map_T_keyframe;
    UncertainPose local;  ///< the same keyframe, as the mapper found it
  };

  Pose2 map_T_local;
  /// Only after a loop. Before, the covariance of the mapper is that of the pose in map.
  std::optional<Known> known;

  /// false: the vehicle began a new map and was not yet found in the old one.
  bool located = true;

  /// The result of the mapper in map. It is at most degraded where the vehicle is not located.
  MapperResult inMap(MapperResult result) const;

 private:
  Eigen::Matrix3d covarianceOf(const UncertainPose& local) const;
};

/// The vehicle moves in a new map whose place in the old one is unknown.
void noteUnlocated(MapperResult& result);

}  // namespace kestrel
