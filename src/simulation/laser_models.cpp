// SPDX-License-Identifier: BSD-3-Clause
#include "find_by_name.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/simulation/sensor_models.h"

namespace kestrel {
namespace {

// Smallest angle between beam and surface at which a matt wall still gives a return.
const double kFlattestCosine = std::sin(degToRad(2.0));

LaserModel idealLaser() {
  LaserModel laser;
  laser.name = "ideal";
  laser.description = "UTM-30LX without measurement errors";
  laser.beams = 1081;
  laser.angle_min = degToRad(-135.0);
  laser.angle_increment = degToRad(0.25);
  laser.rate_hz = 40.0;
  laser.time_increment = 1.0 / laser.rate_hz / 1440.0;  // 1440 steps are one turn of the mirror
  laser.range_min = 0.1;
  laser.range_max = 30.0;
  return laser;
}

LaserModel utm30lx() {
  LaserModel laser = idealLaser();
  laser.name = "utm30lx";
  laser.description = "Hokuyo UTM-30LX: 1081 beams, 270 deg, 40 Hz, 30 m";
  // Repeat accuracy: sigma below 10 mm up to 10 m, below 30 mm up to 30 m.
  laser.errors.sigma_m = 0.01;
  laser.errors.sigma_per_m = 0.00094;
  laser.errors.resolution_m = 0.001;
  laser.errors.dropout_probability = 0.005;
  laser.errors.divergence_rad = degToRad(0.25);  // core of the spot, relevant at edges
  laser.errors.min_cosine = kFlattestCosine;
  return laser;
}

LaserModel urg04lx() {
  LaserModel laser;
  laser.name = "urg04lx";
  laser.description = "Hokuyo URG-04LX: 682 beams, 240 deg, 10 Hz, 5.6 m";
  laser.beams = 682;
  laser.angle_increment = 2.0 * kPi / 1024.0;
  laser.angle_min = -340.5 * laser.angle_increment;
  laser.rate_hz = 10.0;
  laser.time_increment = 1.0 / laser.rate_hz / 1024.0;  // 1024 steps are one turn of the mirror
  laser.range_min = 0.02;
  laser.range_max = 5.6;
  // Accuracy: 10 mm up to 1 m, 1 % of the range beyond.
  laser.errors.sigma_m = 0.003;
  laser.errors.sigma_per_m = 0.01;
  laser.errors.resolution_m = 0.001;
  laser.errors.dropout_probability = 0.02;
  laser.errors.divergence_rad = 0.01;  // a spot of 40 mm at 4 m
  laser.errors.min_cosine = kFlattestCosine;
  return laser;
}

LaserModel sick180() {
  LaserModel laser;
  laser.name = "sick180";
  laser.description = "SICK LMS 200: 180 beams, 1 deg, 5 Hz as logged, 80 m";
  laser.beams = 180;
  laser.angle_min = degToRad(-90.0);
  laser.angle_increment = degToRad(1.0);
  laser.rate_hz = 5.0;
  laser.range_min = 0.02;
  laser.range_max = 80.0;
  laser.errors.sigma_m = 0.01;
  laser.errors.resolution_m = 0.01;
  return laser;
}

LaserModel alasca() {
  LaserModel laser;
  laser.name = "alasca";
  laser.description = "IBEO Alasca, one layer: 481 beams, 240 deg, 12.5 Hz, 200 m";
  laser.beams = 481;
  laser.angle_min = degToRad(-120.0);
  laser.angle_increment = degToRad(0.5);
  laser.rate_hz = 12.5;
  laser.time_increment = 1.0 / laser.rate_hz / 720.0;  // 720 steps are one turn of the mirror
  laser.range_min = 0.3;
  laser.range_max = 200.0;
  laser.errors.sigma_m = 0.05;
  laser.errors.resolution_m = 0.01;
  laser.errors.dropout_probability = 0.01;
  laser.errors.divergence_rad = degToRad(0.25);
  laser.errors.min_cosine = kFlattestCosine;
  return laser;
}

LidarModel vlp16() {
  LidarModel lidar;
  lidar.name = "vlp16";
  lidar.description = "Velodyne VLP-16: 16 rings from -15 to 15 deg, 1800 columns, 10 Hz, 100 m";
  for (int ring = 0; ring < 16; ++ring) lidar.elevations.push_back(degToRad(-15.0 + 2.0 * ring));
  lidar.columns = 1800;
  lidar.rate_hz = 10.0;
  lidar.range_min = 0.5;
  lidar.range_max = 100.0;
  // Accuracy of the data sheet: 30 mm; better at short range.
  lidar.errors.sigma_m = 0.01;
  lidar.errors.sigma_per_m = 0.00028;
  lidar.errors.resolution_m = 0.002;
  lidar.errors.dropout_probability = 0.002;
  lidar.errors.divergence_rad = 0.003;
  lidar.errors.min_cosine = kFlattestCosine;
  return lidar;
}

/// A lidar of Velodyne's HDL series.
LidarModel hdl(const std::string& name, const std::string& description, int columns) {
  LidarModel lidar;
  lidar.name = name;
  lidar.description = description;
  lidar.columns = columns;
  lidar.rate_hz = 10.0;
  lidar.range_min = 1.0;
  lidar.range_max = 100.0;
  lidar.errors.sigma_m = 0.02;  // data sheet: +-2 cm
  lidar.errors.dropout_probability = 0.005;
  lidar.errors.min_cosine = kFlattestCosine;
  return lidar;
}

LidarModel hdl32e() {
  LidarModel lidar = hdl(
      "hdl32e", "Velodyne HDL-32E: 32 rings from -30.67 to 10.67 deg, 2160 columns, 10 Hz", 2160);
  for (int ring = 0; ring < 32; ++ring) {
    lidar.elevations.push_back(degToRad(-30.67 + 4.0 / 3.0 * ring));
  }
  return lidar;
}

/// Two blocks of 32 lasers: steps of 1/2 degree below and of 1/3 degree above.
LidarModel hdl64e() {
  LidarModel lidar =
      hdl("hdl64e", "Velodyne HDL-64E: 64 rings from -24.33 to 2 deg, 2083 columns, 10 Hz", 2083);
  for (int ring = 0; ring < 32; ++ring) {
    lidar.elevations.push_back(degToRad(-24.33 + 0.5 * ring));
  }
  for (int ring = 0; ring < 32; ++ring) {
    lidar.elevations.push_back(degToRad(-8.33 + ring / 3.0));
  }
  return lidar;
}

}  // namespace

const std::vector<LaserModel>& laserModels() {
  static const std::vector<LaserModel> lasers = {utm30lx(), urg04lx(), sick180(), alasca(),
                                                 idealLaser()};
  return lasers;
}

const std::vector<LidarModel>& lidarModels() {
  static const std::vector<LidarModel> lidars = {vlp16(), hdl32e(), hdl64e()};
  return lidars;
}

const LaserModel& laserModel(const std::string& name) {
  return findByName(laserModels(), "sensor", name);
}

}  // namespace kestrel
