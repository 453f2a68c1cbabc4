// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/gyro_check.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {

/// Why a reading is not used.
struct ImuFault {
  std::string reason;   ///< a short phrase for statistics
  std::string message;  ///< for the user: the values, and what to do
};

/// The fault of a reading, or nothing if all values are usable.
std::optional<ImuFault> faultOf(const ImuSample& sample);

/// The same for an orientation. `whose`: its name in the message ("the IMU's orientation").
std::optional<ImuFault> faultOf(const Eigen::Quaterniond& orientation, const std::string& whose);

/// The same for a stamp (s).
std::optional<ImuFault> faultOfStamp(double stamp);

/// Detects an IMU that sends identical readings (bit for bit).
class FrozenCheck {
 public:
  explicit FrozenCheck(double frozen_s) : frozen_s_(frozen_s) {}

  /// Adds a reading. Returns true if the readings have been identical for frozen_s.
  bool add(const ImuSample& sample);
  double duration() const { return duration_s_; }  ///< how long the readings have been identical, s
  void restart() { *this = FrozenCheck(frozen_s_); }

 private:
  double frozen_s_;
  double duration_s_ = 0.0;
  std::optional<ImuSample> first_;  ///< of the identical readings
};

/// A reading that was validated, for everybody who uses it.
struct CheckedImu {
  ImuSample sample;  ///< without the values that contradict the others; the gyro in rad/s
  Eigen::Isometry3d base_T_imu = Eigen::Isometry3d::Identity();
  std::optional<ImuFault> fault;              ///< of stamp, gyro, accelerometer or mounting
  std::optional<ImuFault> orientation_fault;  ///< of the orientation
  StampCheck::Verdict order = StampCheck::Verdict::kNext;  ///< meaningful without a fault
  double jump_s = 0.0;                                     ///< of the stamp, where `order` is kJump
  double frozen_s = 0.0;  ///< how long the readings have been identical
  /// What is wrong with the values of this IMU compared with each other. The reading is usable.
  std::optional<ImuFault> contradiction;
  bool converted = false;  ///< the gyro was in degrees per second
};

/// Validates the readings of one IMU.
class ImuCheck {
 public:
  /// `base_T_imu`: mounting of the IMU.
  CheckedImu check(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu);

  /// Tells that the gyro is in degrees per second, where others found this out (TurnCheck). From
  /// the next reading on the gyro is converted.
  void convertGyro() { told_degrees_ = true; }

  void restart() { *this = ImuCheck(); }

 private:
  void removeContradictions(CheckedImu& checked);

  StampCheck stamps_;
  FrozenCheck frozen_{0.0};
  GyroCheck gyro_;
  bool told_degrees_ = false;
};

}  // namespace kestrel
