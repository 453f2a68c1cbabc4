// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Whether a file begins as a rosbag. Throws std::runtime_error where it cannot be read.
bool isBag(const std::string& path);

/// Reads a reference trajectory: a file in the TUM format, or `topic` of a rosbag (see
/// readBagReference()). Throws std::runtime_error that names the file and what is wrong.
Trajectory readReference(const std::string& path, const std::string& topic);

}  // namespace kestrel
