// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"

namespace kestrel {

/// Distances around a laser by direction, in equal bins over the full circle, beginning at -pi; NaN
/// where nothing was measured.
std::vector<float> rangesAround(const LaserScan& scan);
std::vector<float> rangesAround(const PointCloud& cloud);

/// The turn from one sweep to the next of the same laser, about the laser's z axis, rad. Compares
/// only the distances by direction, so it depends neither on a map nor on any other sensor.
/// Accurate to a degree or two, which is enough to find a wrong sign or unit. Nothing if the
/// surroundings look the same in several directions, or for turns over 60 degrees.
std::optional<double> turnBetween(const std::vector<float>& before,
                                  const std::vector<float>& after);

}  // namespace kestrel
