// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// The points of a global search, evenly over the walls. Their number is a multiple of `multiple`.
Points spreadPoints(const Points& points, std::size_t multiple);

}  // namespace kestrel
