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

/// Covariance of (x, y, yaw), m² and rad², in a message of ROS (x, y, z, roll, pitch, yaw).
Eigen::Matrix3d planarCovariance(const geometry_msgs::PoseWithCovariance& message);

/// Height in the standard atmosphere, m. Only its changes have a meaning. NaN where the pressure is
/// not above zero.
HeightSample toHeightSample(const sensor_msgs::FluidPressure& message);

/// Yaw of the base where x points east: the angle from the field, turned into the level frame by
/// `stabilized_R_sensor`, to magnetic north. Nothing where the field is not finite or upright.
std::optional<YawMeasurement> toYaw(const sensor_msgs::MagneticField& message,
                                    const Eigen::Quaterniond& stabilized_R_sensor,
                                    double declination_rad);

/// Positions of GPS fixes in the local east-north-up frame of the first one (WGS 84), m.
class LocalFixes {
 public:
  /// The first usable fix becomes `first_position`. Nothing where there is no fix, or it is not
  /// finite.
  std::optional<PositionMeasurement> toPosition(const sensor_msgs::NavSatFix& message,
                                                const Eigen::Vector3d& first_position);
  /// The next fix is the first one again.
  void forget() { origin_.reset(); }

 private:
  struct Origin {
    Eigen::Vector3d earth;        ///< earth-centerd, earth-fixed, m
    Eigen::Matrix3d enu_R_earth;  ///< to the local frame
    Eigen::Vector3d position;     ///< in map, m
  };
  std::optional<Origin> origin_;
};

}  // namespace kestrel
