// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// Which beams of a scan are used, and how far a beam without a return clears.
struct BeamFilterConfig {
  double min_range_m = 0.1;     ///< closer returns are ignored (parts of the vehicle)
  double max_range_m = 80.0;    ///< farther returns only clear free space, up to `clear_range_m`
  double clear_range_m = 10.0;  ///< a beam without a return clears free space up to here; 0: never
  int max_beams = 100000;       ///< scans with more beams are rejected
};

/// A range of beam angles in the laser frame, rad, from < to.
struct AngleRange {
  double from = 0.0;
  double to = 0.0;
};

/// Which part of a scan is mapped: a horizontal slice of the world. All defaults are defined here.
struct ProjectorConfig {
  BeamFilterConfig beams;
  double slice_min_m = -1.5;  ///< end points lower than this, relative to the laser, are not mapped
  double slice_max_m = 1.5;  ///< end points higher than this, relative to the laser, are not mapped
  double max_tilt_rad = 0.6;     ///< scans are rejected if the vehicle is tilted more than this
  double floor_margin_m = 0.15;  ///< end points within this distance of the floor or the ceiling
                                 ///< count as floor or ceiling
  double height_m = 0.0;   ///< height of the base over the floor if nothing measures it; 0: unknown
  double ceiling_m = 0.0;  ///< height of the ceiling over the floor; 0: unknown
  /// End points within this radius of the base are parts of the vehicle.
  double vehicle_radius_m = 0.0;
  /// A beam between two range jumps larger than this is a mixed pixel; 0: off. Wider than the noise
  /// of two ranges (10 mm each), and less than the depth of a door frame: a mixed pixel lies behind
  /// the edge, so that all edges seem farther away, and the map of a corridor becomes too long.
  double mixed_pixel_jump_m = 0.05;
  /// Beams that keep a short range while the rest of the view changes hit the vehicle.
  bool find_vehicle = true;
  /// "from:to, from:to" in degrees: beams that hit the vehicle's frame.
  std::string ignored_angles;
  std::string mirror_angles;  ///< the same format: beams that a mirror deflects downwards
  /// "range:correction, …" in m, for a laser with a known range error.
  std::string range_correction;
  double mirror_distance_m = 0.1;  ///< distance from the laser to the mirror
  int azimuth_bins = 1080;         ///< number of azimuth bins in the slice of a 3D lidar
};

/// Parses "from:to, from:to" (degrees). Throws std::invalid_argument with the text if it is
/// invalid.
std::vector<AngleRange> parseAngleRanges(const std::string& text);

}  // namespace kestrel
