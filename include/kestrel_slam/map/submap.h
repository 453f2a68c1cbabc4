// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/map/surfel_field.h"

namespace kestrel {

/// A scan that entered the map.
struct Keyframe {
  Pose2 map_T_base;
  std::vector<Eigen::Vector2f> hits;  ///< end points in base, m, in the order of the sweep
};

/// What a submap does beside its grid and its surface.
struct SubmapOptions {
  std::size_t kept_scans = 0;  ///< so many of the last inserted scans stay at hand as keyframes
  /// Only hits that have no point of the map beside them enter it (paper 004, "the non-associated
  /// parts are pushed onto the map"). The others keep their cell from being cleared.
  bool stitching = false;
};

/// A log-odds grid, the matching surface that is derived from it, and the last scans.
class Submap {
 public:
  explicit Submap(const OccupancyGridConfig& config, const SubmapOptions& options = {});

  /// Inserts a scan and brings the surface up to date; false where the memory limit kept a part
  /// out.
  bool insert(const PlanarScan& scan, const Pose2& map_T_base, bool new_view = false);

  void clear();

  const OccupancyGrid& grid() const { return grid_; }
  const SurfelField& surface() const { return surface_; }
  const std::deque<Keyframe>& keyframes() const { return keyframes_; }  ///< oldest first
  int scans() const { return scans_; }
  /// Names the content: it changes with every insertion, and no two maps share one.
  /// What was derived from a map is still true where the revision is the same.
  std::uint64_t revision() const { return revision_; }
  std::size_t memoryBytes() const;

 private:
  PlanarScan stitched(const PlanarScan& scan, const Pose2& map_T_base) const;
  void keep(const PlanarScan& scan, const Pose2& map_T_base);

  SubmapOptions options_;
  OccupancyGrid grid_;
  SurfelField surface_;
  std::deque<Keyframe> keyframes_;
  int scans_ = 0;
  std::uint64_t revision_;
};

}  // namespace kestrel
