// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Reads a reference trajectory (motion capture, ground truth) from the PoseStamped,
/// PoseWithCovarianceStamped or Odometry topic of a bag, by the stamps in the headers, ascending,
/// each once. `topic` may be "" where the bag has only one that could be meant.
///
/// Throws std::runtime_error that names the bag and lists the topics.
Trajectory readBagReference(const std::string& path, const std::string& topic);

}  // namespace kestrel
