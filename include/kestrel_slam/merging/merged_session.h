// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/merging/map_merger.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// The session of all vehicles in the group of `vehicle`, with poses in `world`. Keyframes come
/// one vehicle after the other, with new ids, which stay the same when maps grow.
Session mergedSession(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                      std::size_t vehicle);

/// The map of all keyframes of the group of `vehicle`.
MapSnapshot mapOf(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                  std::size_t vehicle, const OccupancyGridConfig& config);

/// Why these maps cannot be given to a MapMerger together: two have one name, or the same
/// keyframes; "" if they can.
std::string problemOf(const std::vector<VehicleMap>& vehicles);

}  // namespace kestrel
