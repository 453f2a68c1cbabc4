// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// The angles and limits of a laser, for recordings that only give its number of beams.
struct Fan {
  const char* laser = "";                   ///< its name
  double angle_increment = 0.0;             ///< rad
  double range_min = 0.0, range_max = 0.0;  ///< m
  bool known = true;                        ///< false: no known laser has this number of beams
};

/// The laser with `beams` beams. Its field of view is symmetric about the x axis.
Fan fanOf(std::size_t beams);

/// A scan of this laser without stamp and ranges. The mirror turns once per scan, which gives the
/// time between two beams.
LaserScan scanOf(const Fan& fan, std::size_t beams, double rate_hz);

}  // namespace kestrel
