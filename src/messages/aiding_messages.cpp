// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/messages/aiding_messages.h"

#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

constexpr double kLeastFieldShare = 0.05;  // smallest horizontal share of a usable field

// The standard atmosphere (ISO 2533) up to 11 km.
constexpr double kSeaLevelPa = 101325.0, kScaleHeightM = 44330.77, kExponent = 0.190263;

// WGS 84.
constexpr double kEquatorM = 6378137.0, kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);

constexpr double kUnknownFixSigmaM = 5.0;

Eigen::Vector3d earthOf(double latitude, double longitude, double altitude) {
  const double sine = std::sin(latitude), cosine = std::cos(latitude);
  const double normal = kEquatorM / std::sqrt(1.0 - kEccentricity2 * sine * sine);
  return {(normal + altitude) * cosine * std::cos(longitude),
          (normal + altitude) * cosine * std::sin(longitude),
          (normal * (1.0 - kEccentricity2) + altitude) * sine};
}

Eigen::Matrix3d enuFromEarth(double latitude, double longitude) {
  const double sp = std::sin(latitude), cp = std::cos(latitude);
  const double sl = std::sin(longitude), cl = std::cos(longitude);
  Eigen::Matrix3d result;
  result << -sl, cl, 0.0, -sp * cl, -sp * sl, cp, cp * cl, cp * sl, sp;
  return result;
}

Eigen::Matrix3d covarianceOf(const sensor_msgs::NavSatFix& message) {
  if (message.position_covariance_type == sensor_msgs::NavSatFix::COVARIANCE_TYPE_UNKNOWN) {
    return kUnknownFixSigmaM * kUnknownFixSigmaM * Eigen::Matrix3d::Identity();
  }
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
      message.position_covariance.data());
}

}  // namespace

Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& message) {
  constexpr int kPlace[] = {0, 1, 5};  // indices of x, y, yaw
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> all(
      message.covariance.data());
  Eigen::Matrix3d result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      result(row, column) = all(kPlace[row], kPlace[column]);
    }
  }
  return result;
}

HeightSample toHeightSample(const sensor_msgs::FluidPressure& message) {
  const double pressure = message.fluid_pressure;
  const double height = pressure > 0.0
                            ? kScaleHeightM * (1.0 - std::pow(pressure / kSeaLevelPa, kExponent))
                            : std::numeric_limits<double>::quiet_NaN();
  return {toSeconds(message.header.stamp), height};
}

std::optional<YawMeasurement> toYaw(const sensor_msgs::MagneticField& message,
                                    const Eigen::Quaterniond& stabilized_R_sensor,
                                    double declination_rad) {
  const Eigen::Vector3d field(message.magnetic_field.x, message.magnetic_field.y,
                              message.magnetic_field.z);
  const Eigen::Vector2d level = (stabilized_R_sensor * field).head<2>();
  if (!field.allFinite() || !(level.norm() > kLeastFieldShare * field.norm())) return std::nullopt;
  const double to_north = std::atan2(level.y(), level.x());  // from the x axis of the vehicle
  const double north = kPi / 2.0 - declination_rad;          // from east
  return YawMeasurement{toSeconds(message.header.stamp), normalizeAngle(north - to_north), 0.0};
}

std::optional<PositionMeasurement> LocalFixes::toPosition(const sensor_msgs::NavSatFix& message,
                                                          const Eigen::Vector3d& first_position) {
  const bool has_fix = message.status.status >= sensor_msgs::NavSatStatus::STATUS_FIX;
  const double latitude = degToRad(message.latitude), longitude = degToRad(message.longitude);
  const Eigen::Vector3d earth = earthOf(latitude, longitude, message.altitude);
  if (!has_fix || !earth.allFinite()) return std::nullopt;
  if (!origin_) origin_ = Origin{earth, enuFromEarth(latitude, longitude), first_position};
  return PositionMeasurement{toSeconds(message.header.stamp),
                             origin_->position + origin_->enu_R_earth * (earth - origin_->earth),
                             covarianceOf(message)};
}

}  // namespace kestrel
