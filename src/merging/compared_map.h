// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/merging/joint_map.h"
#include "seen_heights.h"

namespace kestrel {

constexpr double kComparedCellM = 0.1;
/// A wall that the other map has so near, across its direction, is the same one: maps have errors.
/// Along the wall they do not matter, and what stands beside a part of it does not explain the
/// rest.
constexpr double kSameWallM = 0.3;
/// Both vehicles must be sure: several hits, and several beams that passed.
constexpr SureCells kSure;

/// The map of one of two vehicles that are compared, from some of its keyframes.
class ComparedMap {
 public:
  /// `used`: for each keyframe of `joint`, whether it is used. All arguments must outlive the map.
  ComparedMap(const JointMap& joint, const std::vector<PoseVertex>& poses,
              const std::vector<bool>& used, std::size_t part);

  const OccupancyGrid& grid() const { return grid_; }
  /// Whether the height of any scan is known.
  bool knowsHeights() const { return passed_.has_value(); }
  /// Whether beams passed a cell and went on, at any height. Only if heights are known.
  bool isPassed(const Cell& cell) const {
    return passed_ && passed_->probability(cell) <= kSure.free;
  }
  /// What each scan shows at the points.
  std::vector<Sightings> sightings(const std::vector<ComparedPoint>& points) const;

 private:
  template <typename Visit>
  void forEachScan(Visit visit) const;

  const JointMap& joint_;
  const std::vector<PoseVertex>& poses_;
  const std::vector<bool>& used_;
  const JointMap::Part& part_;
  OccupancyGrid grid_;
  std::optional<OccupancyGrid> passed_;
};

}  // namespace kestrel
