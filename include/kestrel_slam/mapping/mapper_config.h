#pragma once

#include <string>

#include "kestrel_slam/map/occupancy_grid_config.h"

namespace kestrel_slam {

/// All parameters of the mapper. The defaults live here and nowhere else.
struct MapperConfig {
  OccupancyGridConfig grid;
  std::string matcher = "hybrid";  ///< gauss_newton, correlative or hybrid

  double insert_distance_m = 0.25;    ///< a scan enters the map after this much motion,
  double insert_angle_rad = 0.25;     ///< or this much rotation
};

}  // namespace kestrel_slam
