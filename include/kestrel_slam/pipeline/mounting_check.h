// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/turn_check.h"

namespace kestrel {

/// Compares what the scans show with the gyro, the odometry and the mountings in tf. Finds a laser
/// or an IMU that is mounted other than tf says, a gyro in degrees per second, and stamps of
/// different clocks.
class MountingCheck {
 public:
  /// Adds the mounting of a laser at one scan.
  void addMounting(const std::string& source, const Eigen::Isometry3d& base_T_laser);
  /// Whether the scan of `source` at `time` (s) is to be added. Not every scan is compared.
  bool isDue(const std::string& source, double time) const;
  /// `ranges`: from rangesAround(). `time`: middle of the sweep, s.
  void addScan(const std::string& source, double time, std::vector<float> ranges,
               const Eigen::Isometry3d& base_T_laser);
  /// Adds the yaw of the odometry, rad.
  void addOdometry(double time, double yaw);
  void compareGyro(const AttitudeBuffer& attitude);

  /// True if the gyro contradicts the scans: its yaw must not be used.
  bool gyroMisleads() const;
  /// True if the gyro is in degrees per second. Not for a gyro that was converted.
  bool gyroInDegrees() const { return gyro_.verdict() == RotationVerdict::kDegrees; }

  /// What is wrong, for the user. Each problem has another reason.
  std::vector<ImuFault> problems() const;
  /// The same where the vehicle is assumed to be level.
  std::vector<ImuFault> problemsOfLevelLaser() const;

 private:
  struct Laser {
    double time = 0.0;
    std::vector<float> ranges;
  };
  struct Yaw {
    double time, yaw;
  };

  std::optional<double> odometryAt(double time) const;

  std::map<std::string, Laser> lasers_;
  std::map<std::string, Eigen::Vector3d> first_axes_;  ///< z axis of each laser at its first scan
  double tilt_rad_ = 0.0;                              ///< largest change of an axis
  std::deque<Yaw> odometry_yaws_;                      ///< not wrapped, ascending times
  TurnCheck gyro_, odometry_;
};

}  // namespace kestrel
