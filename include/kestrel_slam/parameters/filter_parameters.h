// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/filter/pose_filter_config.h"
#include "kestrel_slam/parameters/parameters.h"

namespace kestrel {

/// The table of the pose filter's parameters, bound to `config`, which must outlive it.
std::vector<Parameter> parametersOf(PoseFilterConfig& config);

}  // namespace kestrel
