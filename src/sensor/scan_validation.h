// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// The limits of one scan, in the type of its ranges so that equal numbers compare equal.
struct RangeLimits {
  float min;    ///< closer is too close
  float max;    ///< here and beyond is no return
  float clear;  ///< a beam without a return clears up to here; 0: not at all
};

RangeLimits limitsOf(const LaserScan& scan, const BeamFilterConfig& config);

Projection refused(ScanError error, const std::string& message);

/// The reason to refuse a scan before looking at its ranges.
std::optional<Projection> checkHeader(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                                      const BeamFilterConfig& config);

/// What is wrong with a mounting, or an empty text.
std::string mountingProblem(const Eigen::Isometry3d& base_T_sensor);

/// The sentence for a scan without any usable beam.
std::string noValidBeamText(const BeamCounts& counts);

}  // namespace kestrel
