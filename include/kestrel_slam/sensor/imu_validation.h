// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// Why a reading is not used.
struct ImuFault {
  std::string reason;   ///< a short phrase, as used in statistics
  std::string message;  ///< with the values, and what to do
};

/// What makes the values of a reading unusable.
std::optional<ImuFault> faultOf(const ImuSample& sample);

/// The same for an orientation alone; `whose` names it ("the IMU's orientation").
std::optional<ImuFault> faultOf(const Eigen::Quaterniond& orientation, const std::string& whose);

/// The same for a stamp alone.
std::optional<ImuFault> faultOfStamp(double stamp);

/// Recognizes readings that are the same again and again, bit for bit.
class FrozenCheck {
 public:
  explicit FrozenCheck(double frozen_s) : frozen_s_(frozen_s) {}

  /// Takes a reading; whether it has been the same for frozen_s.
  bool add(const ImuSample& sample);
  double duration() const { return duration_s_; }  ///< for how long it has been the same, s
  void restart() { *this = FrozenCheck(frozen_s_); }

 private:
  double frozen_s_;
  double duration_s_ = 0.0;
  std::optional<ImuSample> first_;  ///< of those that are the same
};

}  // namespace kestrel
