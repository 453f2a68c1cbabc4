// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_tracker.h"

namespace kestrel {

/// Checks over some seconds whether attitude and accelerometer are consistent. Detects an IMU whose
/// mounting differs from tf, and wrong units or signs.
class MountingMonitor {
 public:
  explicit MountingMonitor(double gravity_gate) : gravity_gate_(gravity_gate) {}

  /// Adds an attitude. `dt`: time since the previous one, s. `force`: specific force in the base
  /// frame, m/s². `estimated`: the attitude was computed from it.
  void add(double dt, const Eigen::Quaterniond& world_R_base,
           const std::optional<Eigen::Vector3d>& force, bool estimated);

  /// kOk, kUpsideDown or kContradiction.
  ImuHealth health() const { return judge().health; }
  /// A sentence for the user. Not empty also if the health is kOk but the accelerometer is
  /// suspicious.
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
  double tipped_s_ = 0.0;  ///< how long z has pointed down
  double lying_s_ = 0.0;   ///< how long the tilt has been larger than in any flight
  double force_s_ = 0.0;   ///< duration of the forces in the means
  Eigen::Vector3d mean_force_ = Eigen::Vector3d::Zero();  ///< specific force without yaw, m/s²
  double mean_size_ = 0.0;  ///< mean norm of the specific force, m/s²
};

/// Describes a norm of the accelerometer that is not gravity, with a guess of its unit ("1 m/s²
/// instead of 9.81: it seems to be in g").
std::string describeSize(double size);

}  // namespace kestrel
