// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/map/surfel_field.h"

namespace kestrel {

/// A scan that was inserted into the map.
struct InsertedScan {
  Pose2 map_T_base;
  /// End points in the base frame, m, in the order of the sweep.
  std::vector<Eigen::Vector2f> hits;
};

/// Options of a submap.
struct SubmapOptions {
  std::size_t kept_scans = 0;  ///< number of latest scans that are kept as keyframes
  /// Insert only hits without a nearby point of the map ([multi-robot ICP, sec. 3]: "the
  /// non-associated parts are pushed onto the map"). The cells of all other hits are not cleared.
  bool stitching = false;
};

/// A log-odds grid, the surface for matching that is derived from it, and the latest scans.
class Submap {
 public:
  explicit Submap(const OccupancyGridConfig& config, const SubmapOptions& options = {});

  /// Inserts a scan and updates the surface. `new_view`: see OccupancyGrid::insert. Returns false
  /// if the memory limit kept a part out. `number`: of the scan, see Surfel::birth.
  bool insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view, std::uint32_t number);
  /// The same with the freeCells of a grid with the same resolution; not for `stitching`.
  bool insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view, std::uint32_t number,
              const FreeCells& free);
  /// The same, numbered from 0.
  bool insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view = false) {
    return insert(scan, map_T_base, new_view, static_cast<std::uint32_t>(scans_));
  }

  void clear();

  const OccupancyGrid& grid() const { return grid_; }
  OccupancyGrid& grid() { return grid_; }
  const SurfelField& surface() const { return surface_; }
  const std::deque<InsertedScan>& keyframes() const { return keyframes_; }  ///< oldest first
  int scans() const { return scans_; }
  /// The memory limit kept a part of some scan out.
  bool isFull() const { return full_; }
  /// Identifies the content. It changes with every insertion and is unique among all submaps. Data
  /// that was derived from a map is valid as long as the revision is the same.
  std::uint64_t revision() const { return revision_; }
  std::size_t memoryBytes() const;

 private:
  PlanarScan stitched(const PlanarScan& scan, const Pose2& map_T_base) const;
  bool update(const OccupancyGrid::Changes& changes, const PlanarScan& scan,
              const Pose2& map_T_base, std::uint32_t number);
  void keep(const PlanarScan& scan, const Pose2& map_T_base);

  SubmapOptions options_;
  SharedBudget budget_;
  OccupancyGrid grid_;
  SurfelField surface_;
  std::deque<InsertedScan> keyframes_;
  int scans_ = 0;
  bool full_ = false;
  std::uint64_t revision_;
};

}  // namespace kestrel
