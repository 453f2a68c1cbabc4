// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// A raw sweep of a 2D laser, with the fields and units of sensor_msgs/LaserScan (rad, m, s).
/// Ranges follow REP-117: NaN invalid, +inf no return within range, -inf too close.
struct LaserScan {
  double stamp = 0.0;  ///< time of the first beam as recorded, s
  double angle_min = 0.0;
  double angle_increment = 0.0;
  double time_increment = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  std::vector<float> ranges;
  std::string frame;  ///< of the laser; scans of the same frame come from the same source
};

}  // namespace kestrel
