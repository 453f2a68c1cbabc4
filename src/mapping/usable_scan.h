// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Whether all rays, readings and the time of a scan are finite and of a possible size.
bool isUsable(const PlanarScan& scan);

/// The scan without invalid rays and readings. `last_time` replaces an invalid time, s.
PlanarScan repaired(const PlanarScan& scan, double last_time);

}  // namespace kestrel
