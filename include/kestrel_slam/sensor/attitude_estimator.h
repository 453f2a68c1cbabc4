// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/standstill.h"

namespace kestrel {

/// The rotation by a rotation vector (exponential map), rad.
Eigen::Quaterniond rotationBy(const Eigen::Vector3d& vector);

struct EstimatedAttitude {
  double stamp = 0.0;
  Eigen::Quaterniond world_R_base = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< of the base, in base, without bias, rad/s
};

/// Roll and pitch from gyro and accelerometer: a complementary filter on SO(3) with an estimate of
/// the gyro's bias (Mahony et al. 2008).
///
/// The accelerometer of a quadrotor says nothing of its tilt while it accelerates: its thrust
/// always points along the body's z axis. Therefore the correction is limited to a small rate that
/// a few seconds of acceleration cannot add up, and the limit grows only while the disagreement
/// lasts longer than a vehicle can accelerate in one direction. The yaw only integrates.
class AttitudeEstimator {
 public:
  explicit AttitudeEstimator(const AttitudeConfig& config);

  /// Takes a reading in the base's frame; finite, stamps ascend. Returns the attitudes that it
  /// makes known: none while the first readings are collected, then all of those at once.
  const std::vector<EstimatedAttitude>& add(double stamp, const Eigen::Vector3d& rate,
                                            const Eigen::Vector3d& force);

  const Eigen::Vector3d& gyroBias() const { return bias_; }

  /// The mean specific force of the last start that failed because it is not gravity, m/s².
  std::optional<double> refusedGravity() const { return refused_gravity_; }

  /// Starts again from the next readings; only the bias is kept.
  void restart();

 private:
  struct Reading {
    double stamp = 0.0;
    Eigen::Vector3d rate = Eigen::Vector3d::Zero();
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
  };

  void beginAt(const Reading& reading);
  void collect(const Reading& reading);
  void start(const Reading& reading);
  void step(const Reading& reading, double dt);
  void integrate(const Reading& reading, double dt);
  void correct(const Eigen::Vector3d& rate, double dt);
  void learnStandstill(const Reading& reading, double dt);
  Eigen::Vector3d limited(const Eigen::Vector3d& error, double time_s, double dt);
  void emit(const Reading& reading);

  AttitudeConfig config_;
  std::optional<Reading> last_;
  std::vector<EstimatedAttitude> known_;

  std::vector<EstimatedAttitude> first_;  ///< readings of the start, relative to the first
  Eigen::Vector3d first_force_ = Eigen::Vector3d::Zero();  ///< their sum, in the frame of the first
  std::optional<double> refused_gravity_;

  bool started_ = false;
  Eigen::Quaterniond world_R_base_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();   ///< of the gyro, in base, rad/s
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();  ///< smoothed specific force in world, m/s²
  Eigen::Vector3d limited_direction_ = Eigen::Vector3d::Zero();
  double limited_s_ = 0.0;  ///< for how long the correction has been limited in one direction
  double settled_s_ = 0.0;  ///< for how long gravity has corrected the start
  Standstill standstill_;
  int standstills_ = 0;
};

}  // namespace kestrel
