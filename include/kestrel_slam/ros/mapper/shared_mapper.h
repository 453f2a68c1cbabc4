// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/time.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "kestrel_slam/pipeline/mapping_stage.h"
#include "kestrel_slam/ros/common/fair_mutex.h"

namespace kestrel {

/// A copy of the map, to be published at leisure.
struct MapCopy {
  MapSnapshot map;
  std::uint64_t version = 0;  ///< of the map; another map has another version
  ros::Time stamp;            ///< of the last scan that the mapper saw
};

/// The mapper behind a lock that no caller holds for longer than one match or one copy of the map.
class SharedMapper {
 public:
  explicit SharedMapper(const MapperConfig& config) : mapping_(config) {}

  MapperResult process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                       const ros::Time& stamp);

  /// Forgets the map; the next scan starts a new one at `map_T_base`.
  void reset(const Pose2& map_T_base);

  /// Keeps the map and places the vehicle.
  void setPose(const Pose2& map_T_base);

  /// Keeps map and pose, and forgets the motion: for a gap or a jump of the time.
  void restartMotion();

  MapCopy copy() const;

  /// Changes whenever the map does. Never waits.
  std::uint64_t version() const { return version_; }

  /// Memory of the map, as of the last scan. Never waits.
  std::size_t memoryBytes() const { return memory_bytes_; }

 private:
  mutable FairMutex mutex_;
  MappingStage mapping_;
  ros::Time stamp_;
  std::atomic<std::uint64_t> version_{0};
  std::atomic<std::size_t> memory_bytes_{0};
};

}  // namespace kestrel
