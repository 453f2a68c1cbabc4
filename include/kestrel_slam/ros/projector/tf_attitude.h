// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2_ros/buffer.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// Takes the attitude of the vehicle from tf, where another node publishes it.
class TfAttitude {
 public:
  /// `world_frame`: a frame whose z axis points up.
  TfAttitude(const tf2_ros::Buffer& buffer, const std::string& world_frame,
             const std::string& base_frame, AttitudeTracker& tracker);

  /// Copies the attitudes during a sweep from tf to the tracker. Returns false if tf does not have
  /// them.
  bool fetch(const SweepTimes& times);

  /// A message about the data that is missing in tf.
  std::string missing() const;

 private:
  std::optional<Eigen::Quaterniond> lookup(double time) const;

  const tf2_ros::Buffer& buffer_;
  std::string world_frame_, base_frame_;
  AttitudeTracker& tracker_;
};

}  // namespace kestrel
