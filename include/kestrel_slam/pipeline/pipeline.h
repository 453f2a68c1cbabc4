// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <functional>
#include <optional>

#include "kestrel_slam/filter/pose_filter.h"
#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/pipeline/slam_config.h"
#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/height_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel_slam {

/// What the filter gives to projector and mapper, and how late its poses are.
struct CouplingOptions {
  bool attitude = true;    ///< the filter's attitude, rates and forces feed the projector
  bool height = true;      ///< its height too
  bool prediction = true;  ///< the filter's motion in odom feeds the mapper
  bool barometer = true;
  double match_s = 0.005;  ///< from the last beam's attitude to the mapper's pose, s
};

/// Projector, mapper and pose filter as they run on a vehicle: everything is given to them in the
/// order of arrival, scans wait for the attitude of their last beam, and the mapper's pose reaches
/// the filter late.
class FilteredMapping {
 public:
  FilteredMapping(const SlamConfig& config, const PoseFilterConfig& filter_config,
                  const CouplingOptions& options);

  void addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu, double arrival);
  void addRange(const HeightSample& sample);
  void addBarometer(const HeightSample& sample);
  void addScan(const LaserScan& scan, const Eigen::Isometry3d& base_T_laser);

  const PoseFilter& filter() const { return filter_; }
  Mapper& mapper() { return mapper_; }

  /// Hears of every state of the filter, and of every scan that was processed.
  std::function<void(const FilterOutput&)> on_output;
  std::function<void(const PlanarScan&, const MapperResult&)> on_scan;

 private:
  struct WaitingScan {
    LaserScan scan;
    Eigen::Isometry3d base_T_laser;
  };
  struct WaitingPose {
    double arrival;
    PoseMeasurement pose;
  };

  void chooseAttitude();
  void deliverPoses(double now);
  void processScans(double now);
  bool process(const WaitingScan& waiting, double now);
  const AttitudeBuffer& attitude() const;

  CouplingOptions options_;
  PoseFilter filter_;
  ScanProjector projector_;
  AttitudeTracker tracker_;
  AttitudeBuffer filtered_attitude_;
  bool filter_gives_attitude_ = false;
  bool integrals_jump_ = false;  ///< since the last scan
  HeightTracker height_;
  Mapper mapper_;
  std::deque<WaitingScan> scans_;
  std::deque<WaitingPose> poses_;
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();  ///< in base_stabilized, m/s
};

}  // namespace kestrel_slam
