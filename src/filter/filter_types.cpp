// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/filter/filter_types.h"

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/sensor/attitude_buffer.h"

namespace kestrel {
namespace {

/// Limits for the accuracy that others need. An error of 0.6 degrees changes the height of a beam's
/// end at 10 m by 0.1 m; 0.2 m/s are 5 mm between two scans at 40 Hz.
constexpr double kUsefulTilt = 0.01;  // rad
constexpr double kUsefulSpeed = 0.2;  // m/s
/// LevelFollower detects steps from 0.1 m on.
constexpr double kUsefulHeight = 0.1;  // m

/// Whether the standard deviations of two consecutive states are below `limit`.
bool areKnown(const FilterCovariance& covariance, int first, double limit) {
  return covariance.diagonal().segment<2>(first).maxCoeff() < limit * limit;
}

}  // namespace

const char* toString(FilterSensor sensor) {
  switch (sensor) {
    case FilterSensor::kPose:
      return "pose";
    case FilterSensor::kRange:
      return "range finder";
    case FilterSensor::kFloorBeams:
      return "floor beams";
    case FilterSensor::kBarometer:
      return "barometer";
    case FilterSensor::kYaw:
      return "yaw";
    case FilterSensor::kPosition:
      return "position";
    case FilterSensor::kGravityDirection:
      return "gravity";
    case FilterSensor::kZeroVelocity:
      return "zero velocity";
  }
  return "unknown";
}

const char* toString(FilterHealth health) {
  switch (health) {
    case FilterHealth::kOk:
      return "ok";
    case FilterHealth::kCoasting:
      return "coasting";
    case FilterHealth::kInitializing:
      return "initializing";
    case FilterHealth::kNoImu:
      return "no IMU";
    case FilterHealth::kBadImu:
      return "bad IMU";
  }
  return "unknown";
}

double FilterOutput::yaw() const { return yawOf(Eigen::Quaterniond(map_T_base.linear())); }

Pose2 FilterOutput::odomPose() const {
  return {odom_T_base.translation().x(), odom_T_base.translation().y(),
          yawOf(Eigen::Quaterniond(odom_T_base.linear()))};
}

bool FilterOutput::givesAttitude() const { return areKnown(covariance, kOrientation, kUsefulTilt); }

bool FilterOutput::givesHeight() const { return height_sigma_m < kUsefulHeight; }

bool FilterOutput::givesPrediction() const {
  return !contradicted && areKnown(covariance, kVelocity, kUsefulSpeed);
}

Eigen::Matrix<double, 6, 6> poseCovariance(const FilterOutput& output) {
  const FilterCovariance& p = output.covariance;
  Eigen::Matrix<double, 6, 6> result;
  result.topLeftCorner<3, 3>() = p.block<3, 3>(kPosition, kPosition);
  result.topRightCorner<3, 3>() = p.block<3, 3>(kPosition, kOrientation);
  result.bottomLeftCorner<3, 3>() = p.block<3, 3>(kOrientation, kPosition);
  result.bottomRightCorner<3, 3>() = p.block<3, 3>(kOrientation, kOrientation);
  return result;
}

Eigen::Matrix<double, 6, 6> twistCovariance(const FilterOutput& output, double gyro_sigma) {
  // The velocity in the base frame also depends on the orientation error: Rᵀ (dv + v x d
  // orientation).
  const Eigen::Matrix3d base_R_map = output.map_T_base.linear().transpose();
  const Eigen::Vector3d& v = output.velocity;
  Eigen::Matrix3d turned;
  turned << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  Eigen::Matrix<double, 6, kFilterDim> jacobian = Eigen::Matrix<double, 6, kFilterDim>::Zero();
  jacobian.block<3, 3>(0, kVelocity) = base_R_map;
  jacobian.block<3, 3>(0, kOrientation) = base_R_map * turned;
  jacobian.block<3, 3>(3, kGyroBias) = -Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 6, 6> result = jacobian * output.covariance * jacobian.transpose();
  result.diagonal().tail<3>().array() += gyro_sigma * gyro_sigma;
  return result;
}

}  // namespace kestrel
