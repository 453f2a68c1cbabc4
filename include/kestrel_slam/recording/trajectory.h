// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// A pose (map_T_base) and the recorded stamp of its scan, s.
struct StampedPose {
  double stamp = 0.0;
  Pose2 pose;
};

/// Poses in the order of the recording. Stamps need not be monotone.
using Trajectory = std::vector<StampedPose>;

/// The pose at `stamp`, s, interpolated. `trajectory` has ascending stamps. Nothing outside of it,
/// and where the two nearest poses are more than `max_gap_s` apart.
std::optional<Pose2> poseAt(const Trajectory& trajectory, double stamp, double max_gap_s = 0.5);

/// Write and read the TUM format, with a line `stamp x y z qx qy qz qw` per pose. Stamps have at
/// least six decimals, so that reading gives the same stamp as was written. Both throw
/// std::runtime_error with the name of the file, the line and the error.
void writeTum(const std::string& path, const Trajectory& trajectory);
std::string tumText(const Trajectory& trajectory);  // what writeTum writes
Trajectory readTum(const std::string& path);

}  // namespace kestrel
