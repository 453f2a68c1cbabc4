// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/standstill.h"

namespace kestrel {

/// The rotation for a rotation vector in rad (exponential map).
Eigen::Quaterniond rotationBy(const Eigen::Vector3d& vector);

/// The smallest rotation to a frame in which `up` is the z axis. As FromTwoVectors of Eigen, whose
/// singular value decomposition takes 10 s to compile.
Eigen::Quaterniond leveled(const Eigen::Vector3d& up);

struct EstimatedAttitude {
  double stamp = 0.0;
  Eigen::Quaterniond world_R_base = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< angular velocity of the base, in the base
                                                   ///< frame, bias removed, rad/s
};

/// Roll and pitch from gyro and accelerometer: a complementary filter on SO(3) with an estimate of
/// the gyro bias [Mahony 2008].
///
/// The thrust of a quadrotor always points along the z axis of the body. While the vehicle
/// accelerates, the accelerometer therefore does not show the tilt. For this reason the rate of the
/// correction is limited, so that a few seconds of acceleration change the attitude only slightly.
/// The limit grows only if the disagreement lasts longer than a vehicle can accelerate in one
/// direction. The yaw is only integrated and never corrected.
class AttitudeEstimator {
 public:
  explicit AttitudeEstimator(const AttitudeConfig& config);

  /// Adds a reading in the base frame: `rate` in rad/s, `force` (specific force) in m/s². All
  /// values are finite. Readings whose stamp does not ascend are ignored. Returns the new
  /// attitudes. The first readings are collected, so the result is empty at first and then holds
  /// all collected attitudes at once.
  const std::vector<EstimatedAttitude>& add(double stamp, const Eigen::Vector3d& rate,
                                            const Eigen::Vector3d& force);

  const Eigen::Vector3d& gyroBias() const { return bias_; }

  /// Mean specific force of the last initialization that failed because it was not close to
  /// gravity, m/s².
  std::optional<double> refusedGravity() const { return refused_gravity_; }

  /// Initializes again from the next readings. Only the gyro bias is kept.
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

  /// Attitudes of the initialization, relative to the first.
  std::vector<EstimatedAttitude> first_;
  /// Sum of the forces, in the frame of the first attitude.
  Eigen::Vector3d first_force_ = Eigen::Vector3d::Zero();
  std::optional<double> refused_gravity_;

  bool started_ = false;
  Eigen::Quaterniond world_R_base_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();   ///< of the gyro, in the base frame, rad/s
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();  ///< smoothed specific force in `world`, m/s²
  Eigen::Vector3d limited_direction_ = Eigen::Vector3d::Zero();
  double limited_s_ = 0.0;  ///< how long the correction has been limited in one direction
  /// How long gravity has corrected the attitude since the initialization.
  double settled_s_ = 0.0;
  Standstill standstill_;
  int standstills_ = 0;
};

}  // namespace kestrel
