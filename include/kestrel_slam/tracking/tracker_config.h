// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/tracking/motion_grid.h"
#include "kestrel_slam/tracking/phd_filter.h"

namespace kestrel {

/// The grid of a planar laser: objects in unknown space are followed from the start.
inline MotionGridConfig planarGrid() {
  MotionGridConfig config;
  config.new_s = 1.0;
  return config;
}

/// Parameters of the tracker of moving objects.
struct TrackerConfig {
  MotionGridConfig grid = planarGrid();

  // Clusters of moving points.
  double bandwidth_m = 0.5;  ///< of the mean shift: about the distance of the legs of a person
  double join_gap_m = 0.2;   ///< moving points with gaps up to this are one object
  std::size_t min_points = 2;
  /// The narrowest object. Where the beams are dense, a cluster needs half of the returns that an
  /// object of this width gives.
  double min_width_m = 0.08;

  // Motion and sensor of the PHD filter. The accelerations are for scans at 10 Hz.
  double acceleration_sigma = 2.0;       ///< m/s², constant velocity
  double turn_acceleration_sigma = 1.0;  ///< rad/s², constant turn
  double start_speed_sigma = 0.7;        ///< m/s, of an object that starts to move
  double birth_speed_sigma = 1.5;        ///< m/s, of a new object
  double imposed_m = 0.2;          ///< the imposed dynamic map reaches this far around what moves
  double mode_change_per_s = 0.5;  ///< changes of the motion model
  double position_sigma = 0.06;    ///< m, of the middle of a small object
  double position_sigma_per_m = 0.15;  ///< the same, for each meter of its visible size
  double half_depth_m = 0.1;           ///< of an object behind its visible side, at most
  double cut_sigma = 0.25;             ///< m, added if an object is partly hidden
  double lifetime_s = 20.0;            ///< mean time until an object disappears by itself
  double detection = 0.9;              ///< probability of detection if nothing is in between
  double clutter_per_m2 = 0.02;        ///< false clusters in one scan
  double birth_weight = 0.02;          ///< expected new objects at an observation without a target
  PhdLimits phd;

  // Tracks.
  double coast_s = 1.0;     ///< a visible track without observation is deleted after this time
  double hidden_s = 3.0;    ///< the same for a track that is hidden
  double confirm_s = 0.25;  ///< a track is confirmed after this time with observations
  double motion_significance = 4.0;  ///< an object moves if its velocity is this many sigmas
  double moved_m = 0.5;  ///< an object moves if it has left its place by more than this, and
                         ///< by more than half of its size

  // Bounds on the work of one scan. If one is reached, the result says so.
  std::size_t max_points = 2000;
  std::size_t max_observations = 60;
};

}  // namespace kestrel
