// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Path.h>
#include <ros/time.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel {

/// The path of the vehicle, thinned out evenly and with limited size, so that publishing it costs
/// the same after hours. Thread-safe.
class TrajectoryLog {
 public:
  /// Stores the pose if the vehicle moved or turned enough since the last stored pose.
  void add(const ros::Time& stamp, const Pose2& map_T_base);
  void clear();

  /// Changes with every stored pose and with clear().
  std::uint64_t version() const;

  nav_msgs::Path path(const std::string& frame) const;

  static constexpr double kMinDistance = 0.05;  ///< m
  static constexpr double kMinAngle = 0.1;      ///< rad
  /// If exceeded, every second pose is removed, and from then on poses are stored half as often.
  static constexpr std::size_t kMaxPoses = 5000;

 private:
  struct Entry {
    ros::Time stamp;
    Pose2 pose;
  };

  void halve();

  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  double spacing_ = 1.0;  ///< doubles whenever the poses are halved
  std::uint64_t version_ = 0;
};

}  // namespace kestrel
