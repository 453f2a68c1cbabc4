// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// What rviz shows of the uncertainty of a pose, in the map frame; without header. The first marker
/// is the ellipse of three standard deviations of the position. The second is the direction that
/// the scan does not constrain, as a line through the vehicle; deleted where there is none.
visualization_msgs::MarkerArray uncertaintyMarkers(const MapperResult& result);

}  // namespace kestrel
