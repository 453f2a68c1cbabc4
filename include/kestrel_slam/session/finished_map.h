// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/map/submap.h"

namespace kestrel {

struct Session;

/// The map of a session to localize in: see mapKeyframes().
Submap submapOf(const Session& session, const OccupancyGridConfig& config);

/// A map to localize in, from a session file or from the YAML file of a picture. Throws
/// std::runtime_error with the file and the reason.
Submap loadFinishedMap(const std::string& file, const OccupancyGridConfig& config);

}  // namespace kestrel
