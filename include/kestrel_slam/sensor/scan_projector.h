// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/level_surfaces.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/sensor/projection.h"
#include "kestrel_slam/sensor/range_correction.h"
#include "kestrel_slam/sensor/vehicle_returns.h"

namespace kestrel {

/// State of the vehicle for the projection of a scan.
struct VehicleState {
  const AttitudeBuffer* attitude = nullptr;  ///< null: the vehicle is assumed to be level
  std::optional<double> height_m;            ///< height of the base over the floor, if known
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in base_stabilized, m/s
  double yaw_rate = 0.0;  ///< rad/s; only used if there is no attitude, which measures it
};

/// Converts a sweep to a horizontal slice. Every end point is rotated into the gravity-aligned
/// frame with the attitude at its own time [MAV SLAM 2013, eq. 1-2; Kohlbrecher 2011, sec. IV],
/// corrected for the motion of the vehicle since the reference time (the stamp of the scan), and
/// kept if it lies in the slice. The yaw is left to the mapper.
///
/// Every scan is validated on its own: the number of beams and the geometry may change at any time.
/// Only the heights of floor and ceiling, and the beams that hit the vehicle, are remembered from
/// earlier sweeps.
class ScanProjector {
 public:
  /// Throws std::invalid_argument if the angles or corrections of the configuration are invalid.
  explicit ScanProjector(const ProjectorConfig& config);

  /// `base_T_laser`: mounting of the laser, any position and rotation. Never throws; see
  /// Projection::error.
  Projection project(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                     const VehicleState& vehicle = VehicleState());

  /// The slice of a 3D lidar: the nearest return in the slice for every azimuth bin.
  Projection project(const PointCloud& cloud, const Eigen::Isometry3d& base_T_lidar,
                     const VehicleState& vehicle = VehicleState());

  /// Uses this configuration from the next sweep on. Throws as the constructor does.
  void configure(const ProjectorConfig& config);
  const ProjectorConfig& config() const { return config_; }

 private:
  Projection projectCorrected(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                              const VehicleState& vehicle);
  std::vector<bool> ignoredBeams(const LaserScan& scan);

  ProjectorConfig config_;
  std::vector<AngleRange> ignored_, mirror_;
  RangeCorrection range_correction_;
  LevelSurfaces surfaces_;
  std::map<std::string, VehicleReturns> vehicle_returns_;  ///< by laser
};

/// First and last time of the beams of a sweep, s. The attitudes have to cover this interval.
struct SweepTimes {
  double first = 0.0;
  double last = 0.0;
};
SweepTimes sweepTimes(const LaserScan& scan);
SweepTimes sweepTimes(const PointCloud& cloud);

}  // namespace kestrel
