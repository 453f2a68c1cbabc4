// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

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
  ImuSample sample;
  Eigen::Isometry3d base_T_imu = Eigen::Isometry3d::Identity();
  std::optional<ImuFault> fault;              ///< of stamp, gyro, accelerometer or mounting
  std::optional<ImuFault> orientation_fault;  ///< of the orientation
  StampCheck::Verdict order = StampCheck::Verdict::kNext;  ///< meaningful without a fault
  double jump_s = 0.0;                                     ///< of the stamp, where `order` is kJump
  double frozen_s = 0.0;  ///< how long the readings have been identical
};

/// Validates the readings of one IMU.
class ImuCheck {
 public:
  /// `base_T_imu`: mounting of the IMU.
  CheckedImu check(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu);

  void restart() { *this = ImuCheck(); }

 private:
  StampCheck stamps_;
  FrozenCheck frozen_{0.0};
};

}  // namespace kestrel
