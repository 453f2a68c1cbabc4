// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/submap.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// How much of the walls that a scan and a map show is the same, by length: in squares of 0.1 m.
///
/// Beams are no measure of it. A wall that is near has many beams, and they all fit or fail
/// together: a door that was closed in the map and is open now may be crossed by a third of the
/// beams, but it is a meter of wall.
struct WallAgreement {
  std::size_t hits = 0;     ///< squares with hits of the scan
  std::size_t known = 0;    ///< of them, in the known part of the map
  std::size_t matched = 0;  ///< of them, on a wall of the map
  std::size_t crossed = 0;  ///< squares of walls of the map through which beams would pass

  /// The share of the walls that only the scan or only the map shows, where both know the place.
  double contradiction() const;
  /// The same with its standard deviation: as large as it may really be.
  double possibleContradiction() const;
  /// The share that it is below with 97.7 %, for pieces of wall of half a meter [Wilson 1927, two
  /// standard deviations]. Unlike possibleContradiction, it is large where little wall is seen,
  /// although all of it fits.
  double contradictionBound() const;
  /// Places are compared by it, 0 to 1. Unknown space counts as kUnknownScore.
  double score() const;
  /// Variance of the score: pieces of wall of half a meter fit or fail as a whole.
  double variance() const;
};

/// At the right place the possible contradiction is smaller than this, although furniture moved
/// and doors were opened. Above it, another place is more likely.
constexpr double kMostContradiction = 0.27;

/// A scan at a pose in the map.
struct ScanInMap {
  Pose2 map_T_scan;
  const PlanarScan* scan;
};

/// Compares scans with a map: at most `most_beams` of all beams, evenly.
WallAgreement compareWalls(const Submap& map, const std::vector<ScanInMap>& scans,
                           std::size_t most_beams);

}  // namespace kestrel
