// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// The content of one laser line of a CARMEN log. Poses are in m and rad.
struct CarmenScan {
  LaserScan scan;  ///< `scan.stamp` is the recorded IPC stamp
  Pose2 odom_T_laser;
  Pose2 odom_T_base;
  bool known_fan = true;  ///< false: the line gives no angles, so they are a guess
};

/// Readings at or above this value mean "nothing within range" if the log does not give its own
/// limit, m. (A SICK LMS with a range of 80 m then reports 81.83 or 81.91 m.)
constexpr double kCarmenDefaultMaxRange = 80.0;

/// The name of the message: the first word of the line.
std::string carmenMessageName(const std::string& line);

/// Parses a FLASER or ROBOTLASER1 line. Readings of `no_return_m` (m) or more become +inf. Throws
/// std::invalid_argument with a description of the error in the line.
CarmenScan parseCarmenScan(const std::string& line, double no_return_m);

}  // namespace kestrel
