// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/matching/gauss_newton.h"

namespace kestrel {

/// A scan of a recording with the pose from the mapper.
struct MappedScan {
  Points points;  ///< hits in the base frame, m
  Pose2 pose;     ///< map_T_base
};

/// A mapped recording, for tests and benchmarks of matchers.
struct MappedLog {
  Submap map;
  std::vector<MappedScan> scans;
};

/// Maps the recording `path` with default parameters, as map_recording does without the pose
/// filter. Then inserts the same scans at the same poses into a map with a cell size of
/// `resolution_m`. Throws std::runtime_error if the recording cannot be read.
MappedLog mapLog(const std::string& path, double resolution_m);

}  // namespace kestrel
