// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseWithCovariance.h>
#include <sensor_msgs/FluidPressure.h>
#include <sensor_msgs/MagneticField.h>
#include <sensor_msgs/NavSatFix.h>

#include <Eigen/Geometry>
#include <optional>

#include "kestrel_slam/filter/filter_types.h"
#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// Reads the covariance of (x, y, yaw), m² and rad², from the ROS covariance of (x, y, z, roll,
/// pitch, yaw).
Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& message);

/// Height in the standard atmosphere, m. Use only differences of it. NaN if the pressure is not
/// positive.
HeightSample toHeightSample(const sensor_msgs::FluidPressure& message);

/// Yaw of the base relative to east. `stabilized_R_sensor` rotates the field into the level frame,
/// where its horizontal part points to magnetic north. Empty if the field is not finite or almost
/// vertical.
std::optional<YawMeasurement> toYaw(const sensor_msgs::MagneticField& message,
                                    const Eigen::Quaterniond& stabilized_R_sensor,
                                    double declination_rad);

/// Converts GPS fixes (WGS 84) to positions in a local east-north-up frame at the first fix, m.
class LocalFixes {
 public:
  /// The first usable fix is assigned to `first_position`. Empty if the message has no fix or is
  /// not finite.
  std::optional<PositionMeasurement> toPosition(const sensor_msgs::NavSatFix& message,
                                                const Eigen::Vector3d& first_position);
  /// Resets the local frame. The next fix is the new first fix.
  void forget() { origin_.reset(); }

 private:
  struct Origin {
    Eigen::Vector3d earth;        ///< earth-centered, earth-fixed, m
    Eigen::Matrix3d enu_R_earth;  ///< rotation to the local frame
    Eigen::Vector3d position;     ///< in map, m
  };
  std::optional<Origin> origin_;
};

}  // namespace kestrel
