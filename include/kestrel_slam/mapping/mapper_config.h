// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "kestrel_slam/map/occupancy_grid_config.h"
#include "kestrel_slam/mapping/evaluation_function.h"
#include "kestrel_slam/mapping/local_map.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// All parameters of the mapper. All defaults are defined here.
struct MapperConfig {
  OccupancyGridConfig grid;
  MatcherConfig matcher;
  EvaluationConfig evaluation;
  WindowConfig window;

  double insert_distance_m = 0.25;  ///< a scan is inserted after this motion,
  double insert_angle_rad = 0.25;   ///< or this rotation
  double lost_score = 0.35;         ///< lost if the best score is below this,
  double min_known_share = 0.1;     ///< or if the share of beams in known space is below this
  bool known_poses = false;         ///< the odometry is the pose: nothing is matched
  /// Scans that do not fit the map are matched with the scans before them.
  bool laser_odometry = true;
  double gap_s = 1.0;  ///< all yaws are searched after this time without a scan

  /// Scans are matched against the last submaps, and a pose graph corrects the map.
  bool usesGraph() const { return window.enabled && !known_poses; }
  /// The cells in which scans are matched, m. With the graph the map is drawn from the keyframes at
  /// the end, so that its cells need not limit the poses: in cells of 10 cm a recess of a wall is
  /// no shape, and the yaw of a match depends on how it was cut into cells.
  OccupancyGridConfig matchedGrid() const {
    constexpr double kFineM = 0.05;
    OccupancyGridConfig matched = grid;
    if (usesGraph()) matched.resolution_m = std::min(grid.resolution_m, kFineM);
    return matched;
  }
  /// With known poses there is one map that grows, because nothing corrects it later.
  WindowConfig usedWindow() const {
    WindowConfig used = window;
    used.enabled = usesGraph();
    return used;
  }
};

}  // namespace kestrel
