// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace kestrel {

/// The measurement errors of one beam of a 2D laser or 3D lidar.
struct BeamErrors {
  double sigma_m = 0.0;              ///< standard deviation of a range at distance 0
  double sigma_per_m = 0.0;          ///< proportional part, added as root of the sum of squares
  double resolution_m = 0.0;         ///< ranges are rounded to multiples of it; 0: not rounded
  double dropout_probability = 0.0;  ///< probability that a beam gives NaN
  double divergence_rad = 0.0;       ///< full opening angle; causes mixed ranges at edges
  double min_cosine = 0.0;           ///< of the angle of incidence; below it there is no return
};

/// Data sheet and errors of a 2D laser. The first beam points to `angle_min`.
struct LaserModel {
  std::string name;
  std::string description;
  int beams = 0;
  double angle_min = 0.0;        ///< rad
  double angle_increment = 0.0;  ///< rad
  double time_increment = 0.0;   ///< s between beams
  double rate_hz = 10.0;
  double range_min = 0.0;  ///< m
  double range_max = 0.0;  ///< m
  BeamErrors errors;
};

/// A spinning 3D lidar, such as a VLP-16.
struct LidarModel {
  std::string name;
  std::string description;
  std::vector<double> elevations;  ///< elevation angle of each ring, rad
  int columns = 0;                 ///< firings per turn
  double rate_hz = 10.0;           ///< turns per second
  double range_min = 0.0;          ///< m
  double range_max = 0.0;          ///< m
  BeamErrors errors;
};

/// The known lasers: utm30lx, urg04lx, sick180, alasca, and `ideal`, which has no errors.
const std::vector<LaserModel>& laserModels();
/// The known lidars: vlp16, hdl32e, hdl64e.
const std::vector<LidarModel>& lidarModels();
/// The laser called `name`. Throws std::invalid_argument, which lists the valid names.
const LaserModel& laserModel(const std::string& name);

}  // namespace kestrel
