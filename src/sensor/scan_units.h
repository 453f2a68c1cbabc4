// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/projection.h"
#include "scan_validation.h"

namespace kestrel {

/// Whether the time increment gives a possible sweep. If not, it has another unit or is invalid.
bool hasUsableTimes(const LaserScan& scan);

/// Warnings about a scan that is used all the same.
std::vector<ScanWarning> warningsOf(const LaserScan& scan);

/// Checks a projected scan that has few returns within its limits: ranges, range_min and range_max
/// must have the same unit, m. Returns what contradicts this, or an empty text.
std::string unitProblem(const LaserScan& scan, const BeamCounts& counts);

}  // namespace kestrel
