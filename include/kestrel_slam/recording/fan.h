// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// A laser of which a recording only says how many beams it has.
struct Fan {
  const char* laser = "";  ///< its name
  double angle_increment = 0.0;
  double range_min = 0.0, range_max = 0.0;  ///< m
  bool known = true;                        ///< false: the number of beams is no known laser's
};

/// The laser with `beams` beams, which look to both sides alike.
Fan fanOf(std::size_t beams);

/// A scan of this laser without stamp and ranges. The mirror turns once in each scan, so that a
/// beam comes after the share of a turn that lies between two beams.
LaserScan scanOf(const Fan& fan, std::size_t beams, double rate_hz);

}  // namespace kestrel
