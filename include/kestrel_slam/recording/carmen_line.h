// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// What one laser line of a CARMEN log says.
struct CarmenScan {
  LaserScan scan;  ///< `scan.stamp` is the IPC stamp, as recorded
  Pose2 odom_T_laser;
  Pose2 odom_T_base;
  bool known_fan = true;  ///< false: the angles are a guess, the line does not say them
};

/// Readings from here on mean "nothing within range" where the log does not say (a SICK LMS reports
/// 81.83 or 81.91 m then, and sees 80 m).
constexpr double kCarmenDefaultMaxRange = 80.0;

/// The name of the message: the first word of the line.
std::string carmenMessageName(const std::string& line);

/// Parses a FLASER or ROBOTLASER1 line. `no_return_m`: readings from here on become +inf. Throws
/// std::invalid_argument that says what is wrong with the line.
CarmenScan parseCarmenScan(const std::string& line, double no_return_m);

}  // namespace kestrel
