// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/filter/pose_filter_config.h"
#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// The full state of the vehicle at the rate of the IMU: an error-state Kalman filter (paper 001
/// section III, eq. 1-3 with biases) on gyro and accelerometer, aided by whatever measurements
/// come.
///
/// The mapper's pose is fused by covariance intersection, because the mapper was helped by the
/// filter and its errors are those of the map: however often it is repeated, the filter never
/// claims to know the pose better than the mapper. Every measurement is gated, counted, and applied
/// at its own time: the result is the same in whatever order messages arrive within history_s.
///
/// Knows no clock and no ROS; single-threaded and deterministic. Nothing throws after construction.
/// How to use it: add everything as it arrives; after addImu() has returned true, output() is new.
class PoseFilter {
 public:
  /// Throws std::invalid_argument where the configuration is outside of its limits.
  explicit PoseFilter(const PoseFilterConfig& config = PoseFilterConfig());
  ~PoseFilter();
  PoseFilter(PoseFilter&&) noexcept;
  PoseFilter& operator=(PoseFilter&&) noexcept;

  /// An IMU sample; only gyro and accelerometer are used. `base_T_imu`: its mounting; what it feels
  /// because it is not at the origin of the base, when the vehicle turns, is taken away. True where
  /// output() has moved on to a new stamp.
  bool addImu(const ImuSample& sample,
              const Eigen::Isometry3d& base_T_imu = Eigen::Isometry3d::Identity());

  /// Measurements. False where one is refused at once (status() counts why); one that is newer
  /// than the newest IMU sample waits for it, and may then still be rejected by its gate.
  bool addPose(const PoseMeasurement& measurement);
  /// Distance along the base's negative z axis, m. Steps below (tables) are recognized.
  bool addRange(const HeightSample& sample);
  /// Height of the base over the floor by beams that hit the floor (Projection::floor_height_m, or
  /// mirror_height_m), m.
  bool addFloorHeight(const HeightSample& sample);
  /// Height over anything fixed, m: the offset is estimated, and drifts.
  bool addBarometer(const HeightSample& sample);
  bool addYaw(const YawMeasurement& measurement);
  bool addPosition(const PositionMeasurement& measurement);

  /// The newest state; nothing while initializing.
  const std::optional<FilterOutput>& output() const;

  /// The state at `time` (s) between the oldest that is remembered (history_s) and a little after
  /// the newest, where it is extrapolated: `odom_T_base` fits to the present `map_T_odom`.
  std::optional<FilterOutput> at(double time) const;

  /// Places the vehicle in map (`initialpose`): odom goes on as it was. Before the start it is
  /// where the filter starts. False where something is not finite or no covariance.
  bool setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance);

  /// Starts anew from the next samples; only the counts, the pose in map and odom are kept.
  void restart();

  /// The status at `now`, on the clock of the stamps (s).
  FilterStatus status(double now) const;
  double imuRate() const;  ///< smoothed, Hz; 0 before the second sample

  const PoseFilterConfig& config() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
