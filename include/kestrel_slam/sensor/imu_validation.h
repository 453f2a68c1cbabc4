// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/imu_sample.h"

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

}  // namespace kestrel
