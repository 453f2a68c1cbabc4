// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// Parameters of the log-odds map (paper 000 eq. 6-10, paper 001).
struct OccupancyGridConfig {
  double resolution_m = 0.05;
  double hit_probability = 0.9;     ///< P_occ: what one hit says of its cell
  double miss_probability = 0.4;    ///< P_free: what one beam that passes says of a cell
  double min_probability = 0.05;    ///< clamps: how sure a cell can become,
  double max_probability = 0.97;    ///< and so how fast it can change again
  double memory_limit_mb = 2048.0;  ///< no new cells beyond; reported, never crashed into
};

}  // namespace kestrel
