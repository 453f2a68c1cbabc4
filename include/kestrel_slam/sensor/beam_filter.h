// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// Which beams of a scan are used, and how far a beam without a return clears.
struct BeamFilterConfig {
  double min_range_m = 0.1;     ///< closer returns are ignored (the vehicle itself)
  double max_range_m = 30.0;    ///< farther returns only clear, up to `clear_range_m`
  double clear_range_m = 10.0;  ///< a beam without a return clears free space up to here; 0: off
  int max_beams = 100000;       ///< larger messages are refused
};

/// A range of beam angles in the laser's frame, rad, from < to.
struct AngleRange {
  double from = 0.0;
  double to = 0.0;
};

/// The slice of the world that is mapped. The defaults live here and nowhere else.
struct ProjectorConfig {
  BeamFilterConfig beams;
  double slice_min_m = -1.5;  ///< end points lower than this, relative to the laser, are left out
  double slice_max_m = 1.5;   ///< end points higher than this are left out
  double unknown_m =
      0.6;  ///< as long as floor (ceiling) is unknown, no farther below (above) than this
  double max_tilt_rad = 0.6;     ///< scans of a vehicle tilted farther are dropped
  double floor_margin_m = 0.15;  ///< end points closer to the floor than this are floor
  double height_m = 0.0;   ///< of the base over the floor where nothing measures it; 0: unknown
  double ceiling_m = 0.0;  ///< height of the ceiling over the floor; 0: unknown
  double vehicle_radius_m = 0.0;  ///< end points within this radius are the vehicle's own frame
  double mixed_pixel_jump_m =
      0.1;                       ///< a beam between two jumps of range this large is mixed; 0: off
  std::string ignored_angles;    ///< "from:to, from:to" in degrees: beams that meet the frame
  std::string mirror_angles;     ///< the same: beams that a mirror bends down
  std::string range_correction;  ///< "range:correction, …" in m: the laser's known error
  double mirror_distance_m = 0.1;  ///< from the laser to the mirror
  int azimuth_bins = 1080;         ///< of a 3D lidar's slice
};

/// Reads "from:to, from:to" (degrees). Throws std::invalid_argument that quotes the text.
std::vector<AngleRange> parseAngleRanges(const std::string& text);

}  // namespace kestrel
