// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/map/compact_scan.h"
#include "kestrel_slam/map/map_snapshot.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// Matches every scan of a run once more, with the finished map. While the map grew, the scans were
/// matched with what was known of it at that time.
class Polish {
 public:
  explicit Polish(const MapperConfig& mapper) : mapper_(mapper) {}

  /// Keeps the next scan of the trajectory, in about 4 bytes for each beam.
  void keep(const PlanarScan& scan) { scans_.emplace_back(scan.rays); }

  /// The poses after the match. A scan that does not fit near its pose keeps this pose, and along
  /// an unobservable direction no pose is changed. `trajectory`: one pose for each kept scan,
  /// corrected by the finished `graph`.
  Trajectory polished(const Trajectory& trajectory, const SubmapGraph& graph);

  /// Number of scans that the last call matched.
  std::size_t matchedCount() const { return matched_; }

 private:
  MapperConfig mapper_;
  std::vector<CompactScan> scans_;
  std::size_t matched_ = 0;
};

/// The map of the keyframes, each at the pose that the trajectory has at its stamp.
MapSnapshot mapAlong(const Trajectory& trajectory, const SubmapGraph& graph,
                     const OccupancyGridConfig& config);

}  // namespace kestrel
