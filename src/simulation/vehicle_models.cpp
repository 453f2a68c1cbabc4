// SPDX-License-Identifier: BSD-3-Clause
#include <stdexcept>

#include "kestrel_slam/simulation/flight_simulator.h"

namespace kestrel {

VehicleModel quadrotorWith(const std::string& sensor) {
  const Eigen::Translation3d laser_mount(0.08, 0.0, 0.06), lidar_mount(0.0, 0.0, 0.15);  // m
  VehicleModel vehicle;
  vehicle.base_T_laser = Eigen::Isometry3d(laser_mount);
  vehicle.base_T_lidar = Eigen::Isometry3d(lidar_mount);
  std::string names;
  for (const LaserModel& laser : laserModels()) {
    if (laser.name == sensor) vehicle.laser = laser;
    names += laser.name + ", ";
  }
  for (const LidarModel& lidar : lidarModels()) {
    if (lidar.name == sensor) vehicle.lidar = lidar;
    names += lidar.name + ", ";
  }
  if (!vehicle.laser && !vehicle.lidar) {
    throw std::invalid_argument("unknown sensor '" + sensor +
                                "'; known: " + names.substr(0, names.size() - 2));
  }
  return vehicle;
}

}  // namespace kestrel
