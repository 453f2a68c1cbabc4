// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2_ros/buffer.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// Takes the attitude of the vehicle from tf, where somebody else publishes it.
class TfAttitude {
 public:
  /// `world_frame`: a frame whose z axis points up.
  TfAttitude(const tf2_ros::Buffer& buffer, const std::string& world_frame,
             const std::string& base_frame, AttitudeTracker& tracker);

  /// Brings what tf says about a sweep's time into the tracker; false where tf does not know it.
  bool fetch(const SweepTimes& times);

  /// A sentence about what tf lacks.
  std::string missing() const;

 private:
  std::optional<Eigen::Quaterniond> lookup(double time) const;

  const tf2_ros::Buffer& buffer_;
  std::string world_frame_, base_frame_;
  AttitudeTracker& tracker_;
};

}  // namespace kestrel
