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
  if (result.inserted) ++version_;
  return result;
}

void SharedMapper::reset(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapping_.reset(map_T_base);
  memory_bytes_ = mapping_.mapper().memoryBytes();
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

MapCopy SharedMapper::copy() const {
  const Lock lock(mutex_);
  return {mapping_.mapper().snapshot(), version_, stamp_};
}

}  // namespace kestrel
