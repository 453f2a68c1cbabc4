// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/shared_mapper.h"

#include <mutex>

namespace kestrel {

using Lock = std::lock_guard<FairMutex>;

MapperResult SharedMapper::process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                                   const ros::Time& stamp) {
  const Lock lock(mutex_);
  MapperResult result = mapping_.process(scan, odom_T_base);
  stamp_ = stamp;
  memory_bytes_ = mapping_.mapper().memoryBytes();
  full_ = result.map_full;
  if (result.inserted) ++version_;
  return result;
}

void SharedMapper::reset(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.reset(map_T_base);
  memory_bytes_ = mapping_.mapper().memoryBytes();
  full_ = false;
  ++map_number_;
  ++version_;
}

void SharedMapper::setPose(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.setPose(map_T_base);
}

void SharedMapper::restartMotion() {
  const Lock lock(mutex_);
  mapping_.restartMotion();
}

Pose2 SharedMapper::pose() const {
  const Lock lock(mutex_);
  return mapping_.mapper().pose();
}

MapChanges SharedMapper::takeChanges() {
  constexpr std::size_t kTiles = 32;  // copied in some tens of microseconds
  MapChanges result;
  result.tiles.reserve(kTiles);
  const Lock lock(mutex_);
  result.complete = !mapping_.takeChangedTiles(kTiles, result.tiles);
  result.map_number = map_number_;
  result.version = version_;
  result.stamp = stamp_;
  return result;
}

}  // namespace kestrel
