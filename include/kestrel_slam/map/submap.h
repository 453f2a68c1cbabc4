#pragma once

#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/map/surfel_field.h"

namespace kestrel_slam {

/// A log-odds grid and the matching surface that is derived from it.
class Submap {
 public:
  explicit Submap(const OccupancyGridConfig& config)
      : grid_(config),
        surface_(static_cast<float>(config.resolution_m),
                 static_cast<std::size_t>(config.memory_limit_mb * 1e6)) {}

  /// Inserts a scan and brings the surface up to date; false where the memory limit kept a part
  /// out.
  bool insert(const PlanarScan& scan, const Pose2& map_T_base) {
    const OccupancyGrid::Changes& changes = grid_.insert(scan, map_T_base);
    const bool surface_complete = surface_.update(grid_, changes);
    ++scans_;
    return surface_complete && !changes.full;
  }

  void clear() {
    grid_.clear();
    surface_.clear();
    scans_ = 0;
  }

  const OccupancyGrid& grid() const { return grid_; }
  const SurfelField& surface() const { return surface_; }
  int scans() const { return scans_; }
  std::size_t memoryBytes() const { return grid_.memoryBytes() + surface_.memoryBytes(); }

 private:
  OccupancyGrid grid_;
  SurfelField surface_;
  int scans_ = 0;
};

}  // namespace kestrel_slam
