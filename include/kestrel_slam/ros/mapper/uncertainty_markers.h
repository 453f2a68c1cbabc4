// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// Markers for rviz that show the uncertainty of a pose, in the map frame. The caller sets the
/// header. The first marker is the position ellipse of three standard deviations. The second shows
/// the unobservable direction as a line through the vehicle. It is deleted if there is no such
/// direction.
visualization_msgs::MarkerArray uncertaintyMarkers(const MapperResult& result);

}  // namespace kestrel
