// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// Parameters of the log-odds map [MAV SLAM 2013, eq. 6-10].
struct OccupancyGridConfig {
  double resolution_m = 0.05;
  double hit_probability = 0.9;   ///< P_occ: occupancy probability of a cell after one hit
  double miss_probability = 0.4;  ///< P_free: occupancy probability of a cell that one beam passes
  double min_probability = 0.05;  ///< clamps: the probability of a cell stays in this range,
  double max_probability = 0.97;  ///< so that it can change again quickly
  /// No new cells above this; the map stays usable, and the limit is reported.
  double memory_limit_mb = 2048.0;
};

}  // namespace kestrel
