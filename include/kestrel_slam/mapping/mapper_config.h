// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/map/occupancy_grid_config.h"
#include "kestrel_slam/mapping/evaluation_function.h"
#include "kestrel_slam/matching/matcher.h"

namespace kestrel {

/// All parameters of the mapper. The defaults live here and nowhere else.
struct MapperConfig {
  OccupancyGridConfig grid;
  MatcherConfig matcher;
  EvaluationConfig evaluation;

  double insert_distance_m = 0.25;  ///< a scan enters the map after this much motion,
  double insert_angle_rad = 0.25;   ///< or this much rotation
  double lost_score = 0.35;         ///< a best fit below this is no fit
  double min_known_share = 0.1;     ///< nor is one of fewer beams than this in known space
  double gap_s = 1.0;               ///< after this long without a scan any yaw is searched
};

}  // namespace kestrel
