// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// What became of the beams of one scan. Each beam is counted once.
struct BeamCounts {
  std::size_t hits = 0;
  std::size_t clears = 0;     ///< no return: only clears free space
  std::size_t invalid = 0;    ///< NaN, zero, negative (REP-117)
  std::size_t too_close = 0;  ///< below the minimum range, or -inf
  std::size_t masked = 0;     ///< the vehicle's own frame, or a mirror
  std::size_t mixed = 0;      ///< between two surfaces: neither is there
  std::size_t floor = 0;      ///< hits on the floor; clear what they passed
  std::size_t ceiling = 0;
  std::size_t outside = 0;  ///< above or below the slice; clear what they passed inside of it
};

/// Why a scan gave no planar scan.
enum class ScanError {
  kNone,
  kNoBeams,
  kBadGeometry,
  kTooManyBeams,
  kNoValidBeam,
  kBadStamp,
  kTilted,      ///< the vehicle is tilted beyond the limit
  kNoAttitude,  ///< no attitude for the time of the sweep
};

/// One lower-case word or hyphenated phrase for each error, as used in statistics and diagnostics.
const char* toString(ScanError error);

/// Result of a projection: `scan` is meaningful only where `error` is kNone.
struct Projection {
  PlanarScan scan;
  BeamCounts counts;
  std::optional<double> mirror_height_m;  ///< of the base over the floor, by the mirror's beams
  std::optional<double> floor_height_m;   ///< the same, by beams that hit the floor
  double tilt_rad = 0.0;                  ///< at the reference time
  ScanError error = ScanError::kNone;
  std::string message;  ///< what was wrong, with the values; empty where nothing was
};

}  // namespace kestrel
