// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The sensors of the filter.
enum class FilterSensor {
  kPose,        ///< pose of the mapper
  kRange,       ///< range finder that looks down
  kFloorBeams,  ///< beams of the laser that hit the floor
  kBarometer,
  kYaw,               ///< magnetometer
  kPosition,          ///< GPS
  kGravityDirection,  ///< by the filter itself: direction of gravity from the accelerometer
  kZeroVelocity,      ///< by the filter itself: zero velocity at a standstill
};
constexpr std::size_t kFilterSensors = 8;

/// A lower-case phrase for diagnostics.
const char* toString(FilterSensor sensor);

/// A pose of the mapper: map_T_base in the horizontal plane.
struct PoseMeasurement {
  double stamp = 0.0;  ///< of the scan, s
  Pose2 pose;          ///< map_T_base
  /// Of (x, y, yaw) in the map frame, m² and rad².
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Direction in map along which the pose is not measured but predicted (in a corridor); zero:
  /// none. There the pose is not used.
  Eigen::Vector2d unobservable = Eigen::Vector2d::Zero();
};

/// A yaw of the base in the map frame, from a magnetometer (REP-103: 0 along the x axis of the
/// map).
struct YawMeasurement {
  double stamp = 0.0;
  double yaw = 0.0;    ///< rad
  double sigma = 0.0;  ///< rad; PoseFilterConfig::yaw_sigma_rad is used if larger
};

/// A 3D position in the map frame, such as a GPS fix in a local ENU frame.
struct PositionMeasurement {
  double stamp = 0.0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m²
};

/// Order of the error state: orientation (rotation vector in the map frame from the estimate to the
/// truth, rad), position (m) and velocity (m/s) in the map frame, biases of the gyro (rad/s) and of
/// the accelerometer (m/s²) in the base frame.
enum FilterBlock : int {
  kOrientation = 0,
  kPosition = 3,
  kVelocity = 6,
  kGyroBias = 9,
  kAccelerometerBias = 12
};
constexpr int kFilterDim = 15;
using FilterCovariance = Eigen::Matrix<double, kFilterDim, kFilterDim>;

/// State of the filter at the stamp of an IMU sample.
///
/// `odom_T_base` is continuous: between two samples it moves with the velocity. All corrections of
/// x, y, z and yaw change `map_T_odom`, which is level (REP-105). map_T_base is the product of
/// both.
struct FilterOutput {
  double stamp = 0.0;  ///< s
  Eigen::Isometry3d map_T_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d odom_T_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d map_T_odom = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< in the map frame, m/s
  /// In the base frame, bias removed, rad/s.
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  /// In the base frame, bias removed, m/s².
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           ///< in the base frame, rad/s
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< in the base frame, m/s²
  /// Covariance of the error state in the order of FilterBlock.
  FilterCovariance covariance = FilterCovariance::Zero();
  /// Height of the surface below the range finder over the floor of the map (z = 0), m.
  double ground_m = 0.0;
  double height_sigma_m = 0.0;  ///< standard deviation of height(), m
  bool contradicted = false;    ///< the last pose was rejected, because it does not fit the state

  /// Height of the base over the surface below the range finder, m: the reading of a perfect, level
  /// range finder.
  double height() const { return map_T_base.translation().z() - ground_m; }
  /// Velocity in the base frame, as in the twist of nav_msgs/Odometry, m/s.
  Eigen::Vector3d velocityInBase() const { return map_T_base.linear().transpose() * velocity; }
  double yaw() const;  ///< of the base in the map frame, rad
  /// odom_T_base in the horizontal plane, for PlanarScan::predicted.
  Pose2 odomPose() const;

  /// Whether the state is accurate enough for others: roll and pitch for a projector
  /// (AttitudeBuffer::add), the height for a projector (HeightTracker::addFiltered), the velocity
  /// for the mapper (odomPose). An inaccurate prediction must not be used: the mapper would follow
  /// it along unobservable directions, and its pose would then confirm the wrong prediction.
  bool givesAttitude() const;
  bool givesHeight() const;
  bool givesPrediction() const;
};

/// Covariance of (x, y, z, rotation about x, y, z) in the map frame, as in nav_msgs/Odometry and
/// PoseWithCovariance, m² and rad².
Eigen::Matrix<double, 6, 6> poseCovariance(const FilterOutput& output);
/// Covariance of (velocity, angular velocity) in the base frame, as in the twist of
/// nav_msgs/Odometry. `gyro_sigma`: noise of one reading, rad/s.
Eigen::Matrix<double, 6, 6> twistCovariance(const FilterOutput& output, double gyro_sigma);

/// State of the filter.
enum class FilterHealth {
  kOk,
  kCoasting,      ///< no pose or position recently, or not in all directions: the position drifts
  kInitializing,  ///< collecting samples
  kNoImu,         ///< no sample yet, or none for silent_s
  kBadImu,        ///< frozen, not finite, or gravity has a wrong direction or size
};
const char* toString(FilterHealth health);

/// Number of measurements of one sensor by result.
struct SensorCounts {
  std::size_t received = 0;
  std::size_t accepted = 0;
  std::map<std::string, std::size_t> rejected;  ///< by reason, a lower-case phrase
};

struct FilterStatus {
  FilterHealth health = FilterHealth::kNoImu;
  std::string message;  ///< for the user: what is wrong, the values, and what to do
  SensorCounts imu;
  std::array<SensorCounts, kFilterSensors> sensors;  ///< by FilterSensor
  /// Number of poses and heights to which the filter was reinitialized.
  std::size_t reinitializations = 0;
  std::map<std::string, std::size_t> resets;  ///< by reason
  double imu_rate_hz = 0.0;                   ///< smoothed
  bool started_in_air = false;  ///< the last initialization was in flight, not at a standstill
  const SensorCounts& of(FilterSensor sensor) const {
    return sensors[static_cast<std::size_t>(sensor)];
  }
};

}  // namespace kestrel
