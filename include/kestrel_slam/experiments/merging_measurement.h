// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "kestrel_slam/merging/map_merger.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/trajectory.h"
#include "kestrel_slam/simulation/random_office.h"

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
  std::vector<std::size_t> keyframe_before;  ///< of every scan
};

/// Maps the part, with loops. Throws std::runtime_error if it cannot be read.
MappedVehicle mapVehicle(const VehicleRecording& recording, const SlamConfig& config);

/// Maps `recording`, with loops. Throws std::runtime_error if nothing was mapped.
MappedVehicle mapVehicle(const std::string& name, Recording& recording, SlamConfig config,
                         const RunOptions& options);

/// The map of a simulated quadrotor that visits all rooms of an office. Two vehicles with different
/// numbers begin elsewhere and take other ways.
MappedVehicle mapOffice(std::uint64_t seed, OfficeChange change, std::uint64_t vehicle,
                        const SlamConfig& config);

/// The session of such a vehicle, in an office with so many rooms.
Session officeSession(std::uint64_t seed, std::uint64_t vehicle, std::size_t rooms,
                      const SlamConfig& config);

/// The map as it was when the vehicle had only so many keyframes.
VehicleMap grownTo(const VehicleMap& map, std::size_t count);

/// The poses of all scans of vehicle number `vehicle` in `world`: each scan moves with the keyframe
/// before it.
Trajectory inWorld(const MappedVehicle& mapped, const MergeResult& merged, std::size_t vehicle);

}  // namespace kestrel
