// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// True if the file, decompressed if necessary, begins like a rosbag. Throws std::runtime_error if
/// it cannot be read.
bool isBag(const std::string& path);

/// Reads a reference trajectory from a file in the TUM format or from `topic` of a rosbag (see
/// readBagReference()). Throws std::runtime_error with the name of the file and the error.
Trajectory readReference(const std::string& path, const std::string& topic);

}  // namespace kestrel
