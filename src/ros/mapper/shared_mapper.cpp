// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/shared_mapper.h"

#include <mutex>

namespace kestrel {

using Lock = std::lock_guard<FairMutex>;

MapperResult SharedMapper::process(const PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                                   const ros::Time& stamp) {
  const Lock lock(mutex_);
  MapperResult result = mapper_.process(scan, odom_T_base);
  stamp_ = stamp;
  memory_bytes_ = mapper_.memoryBytes();
  if (result.inserted) ++version_;
  return result;
}

void SharedMapper::reset(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapper_.reset(map_T_base);
  memory_bytes_ = mapper_.memoryBytes();
  ++version_;
}

void SharedMapper::setPose(const Pose2& map_T_base) {
  const Lock lock(mutex_);
  mapper_.setPose(map_T_base);
}

void SharedMapper::restartMotion() {
  const Lock lock(mutex_);
  const Pose2 pose = mapper_.pose();  // a copy: setPose takes a reference
  mapper_.setPose(pose);
}

MapCopy SharedMapper::copy() const {
  const Lock lock(mutex_);
  return {mapper_.snapshot(), version_, stamp_};
}

}  // namespace kestrel
