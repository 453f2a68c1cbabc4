// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/simulation/motion.h"
#include "kestrel_slam/simulation/world.h"

namespace kestrel {

/// The errors of a beam, of a 2D laser and of a 3D lidar alike.
struct BeamErrors {
  double sigma_m = 0.0;              ///< standard deviation of a range
  double sigma_per_m = 0.0;          ///< and its growth with the range
  double resolution_m = 0.0;         ///< ranges are multiples of it; 0: not rounded
  double dropout_probability = 0.0;  ///< of a beam to come back as NaN
  double divergence_rad = 0.0;       ///< full angle; at edges two surfaces are mixed
  double min_cosine = 0.0;           ///< flatter incidence gives no return
};

/// A 2D laser: data sheet and errors. `beams` sweep from angle_min on, `time_increment` apart.
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
  std::vector<double> elevations;  ///< of the rings, rad
  int columns = 0;                 ///< firings a turn
  double rate_hz = 10.0;           ///< turns a second
  double range_min = 0.0;          ///< m
  double range_max = 0.0;          ///< m
  BeamErrors errors;
};

/// One sweep that begins at `time`, every beam cast from where the sensor is at its own time.
/// `stamp` of the result is `time`. Deterministic for one state of `random`.
LaserScan sweep(const LaserModel& laser, const World& world, const Motion& motion,
                const Eigen::Isometry3d& base_T_laser, double time, Random& random);
PointCloud sweep(const LidarModel& lidar, const World& world, const Motion& motion,
                 const Eigen::Isometry3d& base_T_lidar, double time, Random& random);

const std::vector<LaserModel>&
laserModels();  ///< utm30lx, urg04lx, sick180, alasca, and `ideal`: no errors
const std::vector<LidarModel>& lidarModels();  ///< vlp16
/// Finds one by its name. Throws std::invalid_argument that lists the names there are.
const LaserModel& laserModel(const std::string& name);

}  // namespace kestrel
