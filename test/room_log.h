// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/sensor/laser_scan.h"

namespace kestrel {

/// A simulated flight along x in a room: x from -2 to 5 m, y from -1.5 to 2.5 m. A cupboard cuts
/// off one corner. All distances are computed in closed form.
struct RoomFlight {
  static constexpr double kStep_m = 0.05;     ///< between scans
  static constexpr double kPeriod_s = 0.1;    ///< between scans
  static constexpr double kStart_s = 1000.0;  ///< stamp of the first scan
  static constexpr int kStepsOneWay = 40;
  static constexpr int kBeams = 180;  ///< -90 to +89 degrees

  static double stamp(int i) { return kStart_s + kPeriod_s * i; }
  /// Moves back and forth between 0 and 2 m.
  static double x(int i) {
    const int phase = i % (2 * kStepsOneWay);
    return kStep_m * std::min(phase, 2 * kStepsOneWay - phase);
  }

  /// Distance to the nearest wall from (x, 0) along `angle`.
  static double range(double x, double angle) {
    const double dx = std::cos(angle), dy = std::sin(angle);
    const double infinity = std::numeric_limits<double>::infinity();
    const double to_x = dx > 0 ? (5.0 - x) / dx : dx < 0 ? (-2.0 - x) / dx : infinity;
    const double to_y = dy > 0 ? 2.5 / dy : dy < 0 ? -1.5 / dy : infinity;
    // The cupboard: the line x + y = 5.5 in front of the corner (5, 2.5).
    const double to_cupboard = dx + dy > 0 ? (5.5 - x) / (dx + dy) : infinity;
    return std::min({to_x, to_y, to_cupboard});
  }

  static LaserScan scan(int i) {
    LaserScan scan;
    scan.stamp = stamp(i);
    scan.angle_min = -kPi / 2.0;
    scan.angle_increment = degToRad(1.0);
    scan.range_min = 0.05;
    scan.range_max = 80.0;
    for (int b = 0; b < kBeams; ++b) {
      const double angle = scan.angle_min + scan.angle_increment * b;
      scan.ranges.push_back(static_cast<float>(range(x(i), angle)));
    }
    return scan;
  }

  /// The flight as a CARMEN log.
  static std::string carmenLog(int scans) {
    std::ostringstream log;
    log << std::setprecision(12) << "# CARMEN Logfile\n";
    for (int i = 0; i < scans; ++i) {
      log << "FLASER " << kBeams;
      for (const float range : scan(i).ranges) log << ' ' << range;
      log << ' ' << x(i) << " 0 0 " << x(i) << " 0 0 " << std::fixed << stamp(i)
          << std::defaultfloat << " host " << kPeriod_s * i << "\n";
    }
    return log.str();
  }
};

}  // namespace kestrel
