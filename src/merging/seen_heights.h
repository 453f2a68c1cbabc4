// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {

/// What one scan shows at a point: a wall, or free space.
struct Sighting {
  float height_m;  ///< of the scan over the floor; NaN: unknown
  bool wall;
};
using Sightings = std::vector<Sighting>;

/// A point on a wall.
struct ComparedPoint {
  Eigen::Vector2d at;
  Eigen::Vector2d along = Eigen::Vector2d::Zero();  ///< unit vector; zero: unknown
};

/// Collects what the scans of a vehicle show at some points. What a scan hits within `same_wall_m`
/// across the wall is this wall: its beams may miss the point only by the errors of the map. Along
/// the wall, the next cells count, too.
class SightingCollector {
 public:
  SightingCollector(const std::vector<ComparedPoint>& points, double cell_m, double same_wall_m);

  void add(PlanarScan scan, const Pose2& pose);
  /// In the order of the points.
  const std::vector<Sightings>& sightings() const { return sightings_; }

 private:
  bool hasWallAt(const ComparedPoint& point) const;

  const std::vector<ComparedPoint>& points_;
  OccupancyGrid grid_;  ///< of one scan
  double cell_m_, same_wall_m_;
  std::vector<Sightings> sightings_;
};

/// Probabilities from which on cells are sure.
struct SureCells {
  double occupied = 0.9, free = 0.25;
};

enum class HeightVerdict {
  kSaysNothing,
  /// The heights explain it, as at the lintel of a door: on one side of some height both vehicles
  /// saw free space, and on the other side `other` did not. That only one of them saw free space is
  /// no explanation: a building without this door would look the same.
  kExplained,
  /// One vehicle saw the wall between heights at which the other one saw free space.
  kContradicted
};

/// What the heights say about a point at which one vehicle saw a wall and the other one free space.
/// A scan of unknown height counts where it speaks against an explanation.
HeightVerdict compareHeights(const Sightings& walls, const Sightings& other, const SureCells& sure);

}  // namespace kestrel
