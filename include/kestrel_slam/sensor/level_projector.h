#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>

#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel_slam {

/// Which beams of a scan are used, and how far a beam without a return clears.
struct BeamFilterConfig {
  double min_range_m = 0.1;     ///< closer returns are ignored (the vehicle itself)
  double max_range_m = 30.0;    ///< farther returns only clear, up to `clear_range_m`
  double clear_range_m = 10.0;  ///< a beam without a return clears free space up to here; 0: off
  int max_beams = 100000;       ///< larger messages are refused
};

/// What became of the beams of one scan.
struct BeamCounts {
  std::size_t hits = 0;
  std::size_t clears = 0;     ///< no return: only clears free space
  std::size_t invalid = 0;    ///< NaN, zero, negative (REP-117)
  std::size_t too_close = 0;  ///< below the minimum range, or -inf
};

/// Why a scan gave no planar scan.
enum class ScanError { kNone, kNoBeams, kBadGeometry, kTooManyBeams, kNoValidBeam, kBadStamp };

/// One lower-case word or hyphenated phrase for each error, as used in statistics and diagnostics.
const char* toString(ScanError error);

/// Result of a projection: `scan` is meaningful only where `error` is kNone.
struct Projection {
  PlanarScan scan;
  BeamCounts counts;
  ScanError error = ScanError::kNone;
  std::string message;  ///< what was wrong, with the values; empty where nothing was
};

/// Projects the scan of a level laser into the base frame (the identity case of paper 000 eq. 2).
/// Every scan is validated by itself: the number of beams and the geometry may change at any time.
class LevelProjector {
 public:
  explicit LevelProjector(const BeamFilterConfig& config) : config_(config) {}

  /// `base_T_laser`: the mounting of the laser, upside down or rotated at will; the end points are
  /// projected along the base's z axis. `scan.time` of the result is the recorded stamp.
  Projection project(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser) const;

 private:
  BeamFilterConfig config_;
};

}  // namespace kestrel_slam
