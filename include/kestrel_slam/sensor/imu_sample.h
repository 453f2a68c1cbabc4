// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace kestrel {

/// One message of an IMU, with the meaning of sensor_msgs/Imu; what the driver does not give is
/// absent (a covariance of -1 there).
struct ImuSample {
  double stamp = 0.0;                                  ///< s
  std::optional<Eigen::Quaterniond> world_R_imu;       ///< orientation; z of `world` points up
  std::optional<Eigen::Vector3d> angular_velocity;     ///< of the IMU, in its frame, rad/s
  std::optional<Eigen::Vector3d> linear_acceleration;  ///< specific force: +g upwards at rest, m/s²
};

/// One reading of a sensor that measures a distance, such as a range finder that looks down
/// (sensor_msgs/Range, REP-117) or a barometer's height.
struct HeightSample {
  double stamp = 0.0;     ///< s
  double height_m = 0.0;  ///< range finder: along its beam; +inf: nothing in range
};

}  // namespace kestrel
