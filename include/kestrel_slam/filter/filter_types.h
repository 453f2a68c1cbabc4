// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// Who measured something for the filter.
enum class FilterSensor {
  kPose,        ///< the mapper
  kRange,       ///< range finder that looks down
  kFloorBeams,  ///< the laser's own beams that hit the floor
  kBarometer,
  kYaw,               ///< magnetometer
  kPosition,          ///< GPS
  kGravityDirection,  ///< the filter's own: the accelerometer tells where up is
  kZeroVelocity,      ///< the filter's own: the vehicle stands
};
constexpr std::size_t kFilterSensors = 8;

/// Lower case, as used in diagnostics.
const char* toString(FilterSensor sensor);

/// The mapper's pose: map_T_base seen from above.
struct PoseMeasurement {
  double stamp = 0.0;                                    ///< of the scan, s
  Pose2 pose;                                            ///< map_T_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, yaw) in map, m² and rad²
};

/// A magnetometer's yaw: yaw of the base in map (REP-103: 0 is the map's x axis).
struct YawMeasurement {
  double stamp = 0.0;
  double yaw = 0.0;    ///< rad
  double sigma = 0.0;  ///< rad; at least PoseFilterConfig::yaw_sigma_rad is used
};

/// A position in space in map, such as a GPS fix in the local ENU frame.
struct PositionMeasurement {
  double stamp = 0.0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m²
};

/// Order of the error state: orientation (rotation vector in map, that turns the estimate into the
/// truth, rad), position (m), velocity (m/s) in map, bias of the gyro (rad/s) and of the
/// accelerometer (m/s²) in base.
enum FilterBlock : int {
  kOrientation = 0,
  kPosition = 3,
  kVelocity = 6,
  kGyroBias = 9,
  kAccelerometerBias = 12
};
constexpr int kFilterDim = 15;
using FilterCovariance = Eigen::Matrix<double, kFilterDim, kFilterDim>;

/// What the filter says at the stamp of an IMU sample.
///
/// `odom_T_base` is continuous: between two samples it moves as the velocity says. All corrections
/// of x, y, z and yaw go into `map_T_odom`, which is level (REP-105). map_T_base is the product.
struct FilterOutput {
  double stamp = 0.0;  ///< s
  Eigen::Isometry3d map_T_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d odom_T_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d map_T_odom = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            ///< in map, m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();    ///< in base, without bias, rad/s
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();      ///< in base, without bias, m/s²
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();           ///< in base, rad/s
  Eigen::Vector3d accelerometer_bias = Eigen::Vector3d::Zero();  ///< in base, m/s²
  /// Of the error state in the order of FilterBlock, in map.
  FilterCovariance covariance = FilterCovariance::Zero();
  /// How high what is below the range finder stands over the map's floor (z = 0), m.
  double ground_m = 0.0;
  double height_sigma_m = 0.0;  ///< standard deviation of height()

  /// Of the base over what is below the range finder, m: what a perfect one would read upright.
  double height() const { return map_T_base.translation().z() - ground_m; }
  /// Velocity in base, as nav_msgs/Odometry's twist has it, m/s.
  Eigen::Vector3d velocityInBase() const { return map_T_base.linear().transpose() * velocity; }
  double yaw() const;  ///< of the base in map, rad
  /// odom_T_base seen from above: PlanarScan::predicted.
  Pose2 odomPose() const;

  /// Whether roll and pitch are known well enough for a projector (AttitudeBuffer::add), the height
  /// as well (HeightTracker::addFiltered), and the velocity for the mapper (odomPose). A vague
  /// prediction would lead the mapper along what the scans do not constrain, and its pose would
  /// then confirm the prediction.
  bool givesAttitude() const;
  bool givesHeight() const;
  bool givesPrediction() const;
};

/// Covariance of (x, y, z, rotation about x, y, z) in map: what nav_msgs/Odometry and
/// PoseWithCovariance have.
Eigen::Matrix<double, 6, 6> poseCovariance(const FilterOutput& output);
/// Covariance of (velocity in base, angular velocity in base): the twist of nav_msgs/Odometry.
/// `gyro_sigma`: noise of one reading, rad/s.
Eigen::Matrix<double, 6, 6> twistCovariance(const FilterOutput& output, double gyro_sigma);

/// What the filter can be trusted for, the best first.
enum class FilterHealth {
  kOk,
  kCoasting,      ///< no pose or position lately: the position drifts
  kInitializing,  ///< collects samples
  kNoImu,         ///< nothing has come, or nothing for silent_s
  kBadImu,        ///< frozen, not finite, or gravity is not where it has to be
};
const char* toString(FilterHealth health);

/// Measurements of one sensor by what became of them.
struct SensorCounts {
  std::size_t received = 0;
  std::size_t accepted = 0;
  std::map<std::string, std::size_t> rejected;  ///< by reason, a lower-case phrase
};

struct FilterStatus {
  FilterHealth health = FilterHealth::kNoImu;
  std::string message;  ///< a sentence for the user: what is wrong, with values, and what to do
  SensorCounts imu;
  std::array<SensorCounts, kFilterSensors> sensors;  ///< by FilterSensor
  std::size_t reinitializations = 0;          ///< poses and heights taken over against the filter
  std::map<std::string, std::size_t> resets;  ///< by reason
  double imu_rate_hz = 0.0;                   ///< smoothed
  bool started_in_air = false;                ///< the last start was no standstill
  const SensorCounts& of(FilterSensor sensor) const {
    return sensors[static_cast<std::size_t>(sensor)];
  }
};

}  // namespace kestrel
