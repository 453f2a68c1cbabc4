// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_tracker.h"

namespace kestrel {

/// Watches whether attitude and accelerometer make sense together over some seconds: an IMU that is
/// mounted in another way than tf says, or that measures in other units or with other signs.
class MountingMonitor {
 public:
  explicit MountingMonitor(double gravity_gate) : gravity_gate_(gravity_gate) {}

  /// An attitude, `dt` after the one before, s. `force`: of the accelerometer, in the base's frame;
  /// `estimated`: the attitude was made from it.
  void add(double dt, const Eigen::Quaterniond& world_R_base,
           const std::optional<Eigen::Vector3d>& force, bool estimated);

  /// kOk, kUpsideDown or kContradiction.
  ImuHealth health() const { return judge().health; }
  /// A sentence; also where the health is kOk, but the accelerometer is strange.
  std::string message() const { return judge().message; }

  void restart() { *this = MountingMonitor(gravity_gate_); }

 private:
  struct Judgement {
    ImuHealth health = ImuHealth::kOk;
    std::string message;
  };

  Judgement judge() const;
  Judgement judgeTilt() const;
  Judgement judgeDirection() const;
  Judgement judgeSize() const;

  double gravity_gate_;
  bool estimated_ = false;
  double tilt_ = 0.0;      ///< of the last attitude, rad
  double tipped_s_ = 0.0;  ///< for how long z has pointed down
  double lying_s_ = 0.0;   ///< for how long the tilt has been more than any flight's
  double force_s_ = 0.0;   ///< how much of the accelerometer the means hold
  Eigen::Vector3d mean_force_ = Eigen::Vector3d::Zero();  ///< specific force without yaw, m/s²
  double mean_size_ = 0.0;                                ///< of its norm, m/s²
};

/// "0.98 m/s²: is it in g?": what a norm of the accelerometer that is not gravity may be.
std::string describeSize(double size);

}  // namespace kestrel
