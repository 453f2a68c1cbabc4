// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace kestrel {

/// One reading of an IMU, as in sensor_msgs/Imu. Values that the driver does not provide
/// (covariance -1 in the message) are absent.
struct ImuSample {
  double stamp = 0.0;                               ///< s
  std::optional<Eigen::Quaterniond> world_R_imu;    ///< orientation; z of `world` points up
  std::optional<Eigen::Vector3d> angular_velocity;  ///< in the IMU frame, rad/s
  /// Specific force in the IMU frame, m/s²; +g upwards at rest.
  std::optional<Eigen::Vector3d> linear_acceleration;
};

/// One height or distance: from a range finder that looks down (sensor_msgs/Range, REP-117) or from
/// a barometer.
struct HeightSample {
  double stamp = 0.0;     ///< s
  double height_m = 0.0;  ///< range finder: along its beam; +inf: no return
};

}  // namespace kestrel
