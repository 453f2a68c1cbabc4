// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/fan.h"

#include <algorithm>

#include "kestrel_slam/geometry/angles.h"

namespace kestrel {
namespace {

// From the data sheets of Hokuyo.
constexpr double kUtmStepsPerTurn = 1440.0, kUrgStepsPerTurn = 1024.0;
constexpr double kUtmMinRange = 0.1, kUtmMaxRange = 30.0;
constexpr double kUrgMinRange = 0.02, kUrgMaxRange = 5.6;
constexpr double kUnknownFan = degToRad(270.0);

}  // namespace

Fan fanOf(std::size_t beams) {
  if (beams == 1081) return {"UTM-30LX", 2.0 * kPi / kUtmStepsPerTurn, kUtmMinRange, kUtmMaxRange};
  if (beams == 681 || beams == 682) {
    return {"URG-04LX", 2.0 * kPi / kUrgStepsPerTurn, kUrgMinRange, kUrgMaxRange};
  }
  const auto steps = static_cast<double>(std::max<std::size_t>(beams, 2) - 1);
  return {"laser", kUnknownFan / steps, kUtmMinRange, kUtmMaxRange, false};
}

LaserScan scanOf(const Fan& fan, std::size_t beams, double rate_hz) {
  LaserScan scan;
  scan.angle_increment = fan.angle_increment;
  scan.angle_min = -0.5 * fan.angle_increment * static_cast<double>(beams - 1);
  scan.time_increment = fan.angle_increment / (2.0 * kPi) / rate_hz;
  scan.range_min = fan.range_min;
  scan.range_max = fan.range_max;
  return scan;
}

}  // namespace kestrel
