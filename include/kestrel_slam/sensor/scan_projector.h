// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/beam_filter.h"
#include "kestrel_slam/sensor/laser_scan.h"
#include "kestrel_slam/sensor/level_surfaces.h"
#include "kestrel_slam/sensor/point_cloud.h"
#include "kestrel_slam/sensor/projection.h"
#include "kestrel_slam/sensor/range_correction.h"

namespace kestrel {

/// What is known of the vehicle when a scan is projected.
struct VehicleState {
  const AttitudeBuffer* attitude = nullptr;            ///< null: the vehicle is taken to be level
  std::optional<double> height_m;                      ///< of the base over the floor
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< in base_stabilized, m/s
};

/// Turns a sweep into a horizontal slice: every end point is rotated into the gravity-aligned frame
/// with the attitude at its own time (paper 000 eq. 1-2, paper 001 section IV-B), moved to where it
/// is seen from at the reference time (the scan's stamp), and kept where it lies in the slice. Yaw
/// stays with the mapper. Every scan is validated by itself: the number of beams and the geometry
/// may change at any time; all that is remembered is what the sweeps before said of floor and
/// ceiling.
class ScanProjector {
 public:
  /// Throws std::invalid_argument where the configuration's angles or corrections cannot be read.
  explicit ScanProjector(const ProjectorConfig& config);

  /// `base_T_laser`: the mounting of the laser, upside down or rotated at will.
  Projection project(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                     const VehicleState& vehicle = VehicleState());

  /// The slice of a 3D lidar: in every azimuth bin the nearest return that lies in the slice.
  Projection project(const PointCloud& cloud, const Eigen::Isometry3d& base_T_lidar,
                     const VehicleState& vehicle = VehicleState());

  const ProjectorConfig& config() const { return config_; }

 private:
  Projection projectCorrected(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser,
                              const VehicleState& vehicle);

  ProjectorConfig config_;
  std::vector<AngleRange> ignored_, mirror_;
  RangeCorrection range_correction_;
  LevelSurfaces surfaces_;
};

/// First and last time of a sweep's beams, s: what the attitude has to cover.
struct SweepTimes {
  double first = 0.0;
  double last = 0.0;
};
SweepTimes sweepTimes(const LaserScan& scan);
SweepTimes sweepTimes(const PointCloud& cloud);

}  // namespace kestrel
