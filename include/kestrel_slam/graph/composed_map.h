// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/map/occupancy_grid.h"

namespace kestrel {

class SubmapGraph;

/// The map of all keyframes that are joined with the newest one, at their corrected poses.
class ComposedMap {
 public:
  explicit ComposedMap(const OccupancyGridConfig& config) : config_(config), grid_(config) {}

  /// Whether a keyframe has moved so far since it was inserted, or has been joined or separated,
  /// that the map must be composed again.
  bool isOutdated(const SubmapGraph& graph) const;

  /// Inserts the keyframes that were added to `graph` since the last call.
  void add(const SubmapGraph& graph);

  OccupancyGrid& grid() { return grid_; }
  const OccupancyGrid& grid() const { return grid_; }

 private:
  OccupancyGridConfig config_;
  OccupancyGrid grid_;
  std::vector<Pose2> poses_;  ///< at which the keyframes were inserted
  std::vector<bool> shown_;   ///< whether they were
};

}  // namespace kestrel
