// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "kestrel_slam/ros/common/mountings.h"

namespace kestrel {

/// The mounting of a range finder that looks down: from tf, or from a parameter. The beam of a
/// sensor_msgs/Range is the x axis of its frame.
class RangeMounting {
 public:
  /// `parameter`: empty: from tf; or the height of the sensor in the base frame (m), for a sensor
  /// that looks straight down. Throws std::invalid_argument if it is no number.
  RangeMounting(const Mountings& mountings, const std::string& parameter);

  /// Height of the sensor in the base frame, m. Empty if the mounting is not known or does not look
  /// down; then error() is the reason.
  std::optional<double> sensorZ(const std::string& frame);

  const std::string& error() const { return error_; }

 private:
  const Mountings& mountings_;
  std::optional<double> fixed_z_;
  std::string error_;
};

}  // namespace kestrel
