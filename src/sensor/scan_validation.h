// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// Range limits of one scan, m. Floats as the ranges are, so that equal numbers compare equal.
struct RangeLimits {
  float min;    ///< closer returns are invalid
  float max;    ///< ranges from here on are no return
  float clear;  ///< a beam without a return clears free space up to here; 0: never
};

RangeLimits limitsOf(const LaserScan& scan, const BeamFilterConfig& config);

Projection refused(ScanError error, const std::string& message);

/// Checks everything except the ranges. Returns a rejected projection, or nothing if all is valid.
std::optional<Projection> checkHeader(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                      const BeamFilterConfig& config);

/// What is wrong with a mounting; empty if it is valid.
std::string mountingProblem(const Eigen::Isometry3d& base_T_sensor);

/// The message for a scan without any usable beam.
std::string noValidBeamText(const BeamCounts& counts);

}  // namespace kestrel
