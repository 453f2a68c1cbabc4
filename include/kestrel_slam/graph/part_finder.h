// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/graph/place_finder.h"
#include "kestrel_slam/graph/placed_keyframe.h"
#include "kestrel_slam/mapping/mapper_config.h"

namespace kestrel {

/// Looks for a vehicle in the map of older keyframes, whose pose is unknown.
class PartFinder {
 public:
  PartFinder(const MapperConfig& config, const std::vector<PlacedKeyframe>& keyframes);
  PartFinder(const PartFinder&) = delete;
  PartFinder& operator=(const PartFinder&) = delete;

  /// Adds a scan and searches with so much work. Returns map_T_local if the vehicle was found.
  std::optional<Pose2> add(const PlanarScan& scan, const Pose2& local_T_base, std::int64_t work);

  std::size_t memoryBytes() const;

 private:
  Submap map_;
  GlobalMap global_;
  PlaceFinder finder_;
};

}  // namespace kestrel
