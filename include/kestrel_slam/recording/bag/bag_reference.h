// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Reads a reference trajectory (motion capture, ground truth) from a PoseStamped,
/// PoseWithCovarianceStamped or Odometry topic of a bag. The poses are sorted by header stamp, with
/// one pose per stamp. `topic` may be "" if the bag has only one such topic.
///
/// Throws std::runtime_error with the name of the bag and a list of its topics.
Trajectory readBagReference(const std::string& path, const std::string& topic);

}  // namespace kestrel
