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
    /// The same keyframe, as the mapper found it. The error of its match is only here if it is a
    /// part of the covariance above, too.
    UncertainPose local;
  };

  Pose2 map_T_local;
  /// Only after a loop. Before, the covariance of the mapper is that of the pose in map.
  std::optional<Known> known;

  /// false: the vehicle began a new map and was not yet found in the old one.
  bool located = true;

  /// The result of the mapper in map: lost where the vehicle is not located.
  MapperResult inMap(MapperResult result) const;

 private:
  Eigen::Matrix3d covarianceOf(const UncertainPose& local) const;
};

/// The reason of the state while the vehicle moves in a new map whose place in the old one is
/// unknown.
constexpr char kPlaceUnknown[] = "place unknown";
/// Sets this state and reason.
void noteUnlocated(MapperResult& result);

}  // namespace kestrel
