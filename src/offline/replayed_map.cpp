// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/replayed_map.h"

#include <algorithm>

#include "kestrel_slam/matching/matcher.h"

namespace kestrel {
namespace {

OccupancyGridConfig withResolution(OccupancyGridConfig grid, double resolution_m) {
  grid.resolution_m = resolution_m;
  return grid;
}

/// Stitching changes the map, so only the mapper decides on it.
SubmapOptions combined(SubmapOptions mapper, const SubmapOptions& wanted) {
  mapper.kept_scans = std::max(mapper.kept_scans, wanted.kept_scans);
  return mapper;
}

}  // namespace

ReplayedMap::ReplayedMap(const MapperConfig& mapper) : ReplayedMap(mapper, SubmapOptions()) {}

ReplayedMap::ReplayedMap(const MapperConfig& mapper, const SubmapOptions& options)
    : mapper_(mapper), map_(mapper.grid, combined(submapOptions(mapper.matcher), options)) {}

ReplayedMap::ReplayedMap(const MapperConfig& mapper, double resolution_m)
    : mapper_(mapper),
      map_(withResolution(mapper.grid, resolution_m), submapOptions(mapper.matcher)) {}

void ReplayedMap::add(const PlanarScan& scan, const MapperResult& result) {
  if (!result.inserted) return;
  const bool new_view =
      scan.integrated_acceleration && result.match.score < mapper_.matcher.good_score;
  map_.insert(scan, result.pose, new_view);
}

}  // namespace kestrel
