// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace kestrel {

/// A vehicle that hovers in the middle of a room of 8 m × 6 m, oscillates in roll and pitch, and
/// turns. Gives the sensor readings and the expected planar scans in closed form. The walls are so
/// high that beams hit only walls. Times in s.
struct TiltingFlight {
  double roll_amplitude = 0.2;    ///< rad
  double pitch_amplitude = 0.15;  ///< rad
  double yaw_rate = 1.0;          ///< rad/s

  static constexpr int kBeams = 1081;
  static constexpr double kTimeIncrement = 0.025 / 1440.0;  ///< a full turn in 25 ms, 1440 steps
  static constexpr double kSweep = (kBeams - 1) * kTimeIncrement;

  Eigen::Quaterniond world_R_base(double time) const;

  sensor_msgs::Imu imu(double time, const std::string& frame,
                       const Eigen::Quaterniond& base_R_imu = Eigen::Quaterniond::Identity()) const;

  sensor_msgs::LaserScan scan(double time, const std::string& frame,
                              const Eigen::Isometry3d& base_T_laser) const;

  /// End points of the beams of scan() in base_stabilized at `time`. Only those up to `slice_m`
  /// above or below the laser.
  std::vector<Eigen::Vector2f> hits(double time, const Eigen::Isometry3d& base_T_laser,
                                    double slice_m) const;

 private:
  struct Beam {
    double range;
    Eigen::Vector3d end;  ///< in world, relative to the vehicle
  };
  Beam beam(int i, double time, const Eigen::Isometry3d& base_T_laser) const;
  Eigen::Vector3d bodyRate(double time) const;
};

/// A mounting: x, y, z in m; roll, pitch, yaw in rad.
Eigen::Isometry3d mounting(double x, double y, double z, double roll, double pitch, double yaw);

geometry_msgs::TransformStamped transformMessage(const std::string& parent,
                                                 const std::string& child,
                                                 const Eigen::Isometry3d& parent_T_child,
                                                 double time);

}  // namespace kestrel
