// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/lidar/cloud_icp.h"
#include "kestrel_slam/lidar/ground.h"
#include "kestrel_slam/tracking/motion_grid.h"
#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {

/// Voxels are much larger than the cells in the plane, and the bounds let a place change state
/// within a few sweeps.
inline MotionGridConfig voxelGridConfig() {
  MotionGridConfig config;
  config.resolution_m = 0.4;
  config.tolerance_m = 0.25;
  config.tolerance_rad = 0.003;
  config.new_s = 1.0;
  config.keep_radius_m = 80.0;
  config.memory_limit_mb = 350.0;
  return config;
}

/// Parameters of the localization and tracking with a 3D lidar. Where nothing else is said, the
/// values are those of [Siew 2018, sec. V and VI].
struct CloudTrackerConfig {
  double min_range_m = 1.5;  ///< nearer returns are from the vehicle
  double max_range_m = 100.0;
  double free_range_m = 60.0;  ///< beams clear cells up to this distance
  GroundConfig ground;
  CloudIcpConfig icp;
  double surface_resolution_m =
      0.5;  ///< of the map for the localization, and of the matched points
  MotionGridConfig grid = voxelGridConfig();
  double ring_step_deg = 1.33;  ///< between the rings, for the visitation grid

  // Clusters of moving points.
  double bandwidth_m = 0.6;    ///< of the mean shift; the paper has 2.2 m, which joins pedestrians
  double join_gap_m = 0.7;     ///< voxels with gaps up to this are one object
  std::size_t min_points = 5;  ///< of a cluster
  double max_height_m = 4.5;   ///< of the lowest point of an object above the lidar

  // Motion and sensor of the PHD filter.
  double acceleration_sigma = 3.0;       ///< m/s², constant velocity
  double turn_acceleration_sigma = 1.0;  ///< rad/s², constant turn
  double start_speed_sigma = 1.0;        ///< m/s, of an object that starts to move
  double birth_speed_sigma = 8.0;        ///< m/s, of a new object
  double birth_climb_sigma = 0.5;        ///< m/s, the same upwards
  double max_speed = 6.0;                ///< m/s, of something that is not tracked yet
  double mode_change_per_s = 0.5;        ///< changes of the motion model
  double position_sigma = 0.15;          ///< m, of the middle of a small object
  double position_sigma_per_m = 0.08;    ///< the same, for each meter of its size
  double lifetime_s = 20.0;              ///< mean time until an object disappears by itself
  double detection = 0.9;                ///< probability of detection if nothing is in between
  double clutter_per_m3 = 1e-4;          ///< false clusters in one sweep
  double birth_weight = 0.02;  ///< expected new objects at an observation without a target
  PhdLimits phd{1e-4, 4.0, 1000, true};

  // Tracks.
  double coast_s = 1.0;       ///< a visible track without observation is deleted after this time
  double hidden_s = 3.0;      ///< the same for a track that is hidden
  double lost_sigma_m = 2.5;  ///< a target is forgotten if its place is known worse than this
  double confirm_s = 0.25;    ///< a track is confirmed after this time with observations
  double moved_m = 0.7;       ///< an object moves if it has left its place by more than this

  // Bounds on the work of one sweep. If one is reached, the result says so.
  std::size_t max_points = 150000;
  std::size_t max_moving_voxels = 3000;
  std::size_t max_observations = 80;
};

}  // namespace kestrel
