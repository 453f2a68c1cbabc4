// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/sensor/time_base.h"

namespace kestrel {

/// The mapper with the time base that its scans need. The mapper's node and the pipeline run this
/// object. Single-threaded.
class MappingStage {
 public:
  explicit MappingStage(const MapperConfig& config) : mapper_(config) {}

  /// Matches a planar scan. Its `time` becomes `time` (s), where the time base was repaired
  /// already, else its stamp on a monotone time base.
  MapperResult process(PlanarScan& scan, const std::optional<Pose2>& odom_T_base,
                       const std::optional<double>& time = std::nullopt);

  /// Forgets the map; the next scan starts a new one at `map_T_base`.
  void reset(const Pose2& map_T_base) { mapper_.reset(map_T_base); }
  /// Keeps the map and places the vehicle.
  void setPose(const Pose2& map_T_base) { mapper_.setPose(map_T_base); }
  /// Keeps map and pose and forgets the motion: for a gap or a jump of the time.
  void restartMotion();

  const Mapper& mapper() const { return mapper_; }

 private:
  MonotoneTime monotone_time_;
  Mapper mapper_;
};

}  // namespace kestrel
