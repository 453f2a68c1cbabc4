// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

/// The mapper and the monotone time base of its scans. Both the mapper node and the pipeline use
/// this class. Not thread-safe.
class MappingStage {
 public:
  explicit MappingStage(const MapperConfig& config) : mapper_(config) {}

  /// Matches a planar scan. If the caller has already repaired the time base, the argument `time`
  /// (s) is used. Otherwise the time of the scan is computed from its stamp, so that time never
  /// decreases.
  MapperResult process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                       const std::optional<double>& time = std::nullopt);

  /// Deletes the map. The next scan starts a new map at `map_T_base`.
  void reset(const Pose2& map_T_base) { mapper_.reset(map_T_base); }
  /// Keeps the map and sets the pose of the vehicle.
  void setPose(const Pose2& map_T_base) { mapper_.setPose(map_T_base); }
  /// Keeps map and pose but resets the motion model. Used after a gap or a jump in time.
  void restartMotion();

  /// See Mapper::takeChangedTiles.
  bool takeChangedTiles(std::size_t max_tiles, std::vector<TileImage>& images) {
    return mapper_.takeChangedTiles(max_tiles, images);
  }

  const Mapper& mapper() const { return mapper_; }

 private:
  MonotoneTime monotone_time_;
  Mapper mapper_;
};

}  // namespace kestrel
