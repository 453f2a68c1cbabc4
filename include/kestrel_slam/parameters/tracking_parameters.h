// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/tracking/tracker_config.h"

namespace kestrel {

/// The table of the parameters of the tracker, bound to `config`.
std::vector<Parameter> parametersOf(TrackerConfig& config);

}  // namespace kestrel
