// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// Number of beams of one scan by result. Each beam is counted once.
struct BeamCounts {
  std::size_t hits = 0;
  std::size_t clears = 0;     ///< no return; the beam only clears free space
  std::size_t invalid = 0;    ///< NaN, zero, negative (REP-117)
  std::size_t too_close = 0;  ///< below the minimum range, or -inf
  std::size_t masked = 0;     ///< hits the vehicle's frame or a mirror
  std::size_t mixed = 0;      ///< mixed pixel: measured between two surfaces
  std::size_t floor = 0;      ///< hits on the floor; clear the free space before the floor
  std::size_t ceiling = 0;
  std::size_t outside = 0;  ///< above or below the slice; clear the free space inside of it
};

/// Why a scan was rejected.
enum class ScanError {
  kNone,
  kNoBeams,
  kBadGeometry,
  kTooManyBeams,
  kNoValidBeam,
  kBadStamp,
  kTilted,      ///< the vehicle is tilted beyond the limit
  kNoAttitude,  ///< no attitude for the time of the sweep
  kWrongUnit,   ///< ranges and their limits have different units
};

/// A lower-case word or hyphenated phrase for each error, for statistics and diagnostics.
const char* toString(ScanError error);

/// Fewer beams cannot be matched reliably: walls are seen as single points.
constexpr std::size_t kMinBeamsToMatch = 24;

/// What is wrong with a scan that is used all the same.
struct ScanWarning {
  const char* kind;  ///< one of a few words, as ScanError
  std::string text;  ///< with the values
};

/// "kind: text; kind: text"
std::string textOf(const std::vector<ScanWarning>& warnings);

/// Result of a projection. `scan` is valid only if `error` is kNone.
struct Projection {
  PlanarScan scan;
  BeamCounts counts;
  /// Height of the base over the floor, from the beams at the mirror.
  std::optional<double> mirror_height_m;
  std::optional<double> floor_height_m;  ///< the same, from beams that hit the floor
  double tilt_rad = 0.0;                 ///< largest tilt during the sweep
  ScanError error = ScanError::kNone;
  std::string message;                ///< what is wrong, with the values; empty if kNone
  std::vector<ScanWarning> warnings;  ///< if kNone
};

}  // namespace kestrel
