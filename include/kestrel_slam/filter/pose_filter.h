// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/filter/pose_filter_config.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/imu_validation.h"

namespace kestrel {

/// The full state of the vehicle at the rate of the IMU: an error-state Kalman filter [Kohlbrecher
/// 2011, sec. III, eq. 1-3, with biases] on gyro and accelerometer, with any of the other
/// measurements.
///
/// The pose of the mapper is fused by covariance intersection, because its errors are correlated:
/// the mapper uses the prediction of the filter, and all poses share the errors of the map. So
/// repeated poses never make the filter more certain than the mapper. Every measurement is gated,
/// counted, and applied at its own time: within history_s the result does not depend on the order
/// in which messages arrive.
///
/// Uses neither a clock nor ROS; single-threaded and deterministic. Does not throw after
/// construction. Usage: add everything as it arrives; after addImu() has returned true, output() is
/// new.
class PoseFilter {
 public:
  /// Throws std::invalid_argument if a parameter is outside of its limits.
  explicit PoseFilter(const PoseFilterConfig& config = PoseFilterConfig());
  ~PoseFilter();
  PoseFilter(PoseFilter&&) noexcept;
  PoseFilter& operator=(PoseFilter&&) noexcept;

  /// Adds an IMU sample; only gyro and accelerometer are used. `base_T_imu`: mounting of the IMU;
  /// the acceleration that a rotation causes at its position is removed. Returns true if output()
  /// has a new stamp.
  bool addImu(const ImuSample& sample,
              const Eigen::Isometry3d& base_T_imu = Eigen::Isometry3d::Identity());
  /// The same for a reading that was validated already.
  bool addImu(const CheckedImu& reading);

  /// Add a measurement. Return false if it is rejected at once (status() counts the reasons). A
  /// measurement newer than the newest IMU sample waits for the IMU, and may then be rejected by
  /// its gate.
  bool addPose(const PoseMeasurement& measurement);
  /// Distance along the -z axis of the base, m. Steps of the surface below (tables) are detected.
  bool addRange(const HeightSample& sample);
  /// Height of the base over the floor from beams that hit the floor (Projection::floor_height_m or
  /// mirror_height_m), m.
  bool addFloorHeight(const HeightSample& sample);
  /// Height over any fixed reference, m. The offset is estimated and drifts.
  bool addBarometer(const HeightSample& sample);
  bool addYaw(const YawMeasurement& measurement);
  bool addPosition(const PositionMeasurement& measurement);

  /// The newest state; nothing during initialization.
  const std::optional<FilterOutput>& output() const;

  /// The state at `time` (s): from the oldest stored state (history_s) to shortly after the newest,
  /// where it is extrapolated. `odom_T_base` refers to the current `map_T_odom`.
  std::optional<FilterOutput> at(double time) const;

  /// Sets the pose in the map (`initialpose`); odom_T_base stays continuous. Before the
  /// initialization it is the initial pose. Returns false if a value is not finite or the
  /// covariance is invalid.
  bool setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance);

  /// Initializes again from the next samples. Only the counters, the pose in the map and
  /// odom_T_base are kept.
  void restart();

  /// The status at `now` (s, same clock as the stamps).
  FilterStatus status(double now) const;
  double imuRate() const;  ///< smoothed, Hz; 0 before the second sample

  const PoseFilterConfig& config() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
