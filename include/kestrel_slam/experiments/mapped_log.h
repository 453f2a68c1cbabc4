// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// A scan of a recording with the pose that the mapper found.
struct MappedScan {
  Points points;  ///< in the robot's frame, m
  Pose2 pose;     ///< map_T_base
};

/// A recording, mapped, to search in: for tests and benchmarks of single operations.
struct MappedLog {
  Submap map;
  std::vector<MappedScan> scans;
};

/// Maps the recording `path` laser only with the defaults and collects the same scans at the same
/// poses in a map of cells of `resolution_m`. Throws std::runtime_error where it cannot be read.
MappedLog mapLog(const std::string& path, double resolution_m);

}  // namespace kestrel
