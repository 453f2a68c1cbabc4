// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// A pose (map_T_base) and the stamp of the scan that it belongs to, as recorded.
struct StampedPose {
  double stamp = 0.0;
  Pose2 pose;
};

/// In the order of the recording; stamps need not be monotone.
using Trajectory = std::vector<StampedPose>;

/// Writes and reads the TUM format, `stamp x y z qx qy qz qw` a line, stamps with six decimals or
/// more, so that a recorded stamp survives the round trip. Both throw std::runtime_error that names
/// the file (and the line) and what is wrong.
void writeTum(const std::string& path, const Trajectory& trajectory);
Trajectory readTum(const std::string& path);

}  // namespace kestrel
