// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "kestrel_slam/pipeline/pipeline.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Horizontal pose and velocity in map.
struct MovingPose {
  StampedPose pose;
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< m/s
};

/// Errors against a reference, after the best rigid alignment.
struct MovingErrors {
  std::size_t count = 0;
  double position_rmse_m = 0.0;
  double velocity_rmse = 0.0;  ///< m/s; the reference velocity is a difference over 0.2 s
};

/// Throws ReferenceMismatch.
MovingErrors compareWithReference(const std::vector<MovingPose>& poses,
                                  const Trajectory& reference);

/// The mapper's poses and the filter's states of a recording with an IMU.
struct RecordedFilterRun {
  std::vector<MovingPose> mapper;  ///< one per scan that is not lost
  std::vector<MovingPose> filter;  ///< one per IMU sample
  FilterStatus status;             ///< at the end
};

/// Runs projector, mapper and filter on a recording, in the order of its stamps. `base_T_laser`
/// replaces the mounting in the recording. Throws std::runtime_error if the recording has no IMU.
RecordedFilterRun runFiltered(Recording& recording, const SlamConfig& config,
                              const PoseFilterConfig& filter, const CouplingOptions& coupling,
                              const std::optional<Eigen::Isometry3d>& base_T_laser = std::nullopt);

}  // namespace kestrel
