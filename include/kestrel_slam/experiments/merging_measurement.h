// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/merging/map_merger.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// A part of a recording that a vehicle of its own maps.
struct VehicleRecording {
  std::string name;
  std::string path;
  std::size_t first = 0, last = std::numeric_limits<std::size_t>::max();  ///< scans [first, last)
  bool use_odometry = false;
};

/// The parts of a recording that is cut in time.
std::vector<VehicleRecording> cutRecording(const std::string& path, std::size_t parts,
                                           bool use_odometry);

/// What a vehicle has mapped.
struct MappedVehicle {
  VehicleMap map;
  Trajectory trajectory;                     ///< of all scans, in the vehicle's map
  std::vector<std::size_t> keyframe_before;  /// of every scan
};

/// Maps the part, with loops. Throws std::runtime_error if it cannot be read.
MappedVehicle mapVehicle(const VehicleRecording& recording, SlamConfig config);

/// The poses of all scans of vehicle number `vehicle` in `world`: each scan moves with the keyframe
/// before it.
Trajectory inWorld(const MappedVehicle& mapped, const MergeResult& merged, std::size_t vehicle);

/// The map of all keyframes of the group of vehicle `vehicle`.
MapSnapshot mapOf(const std::vector<VehicleMap>& vehicles, const MergeResult& merged,
                  std::size_t vehicle, const OccupancyGridConfig& config);

}  // namespace kestrel
