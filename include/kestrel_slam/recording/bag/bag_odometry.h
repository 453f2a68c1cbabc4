// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Pose.h>

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_topics.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"
#include "kestrel_slam/recording/trajectory.h"

namespace kestrel {

/// The poses of a nav_msgs/Odometry topic, interpolated.
class BagOdometry {
 public:
  BagOdometry(const BagFiles& files, const std::string& topic);

  /// odom_T_child at `stamp` (s). Nothing if the two nearest messages are too far apart (poseAt).
  std::optional<Pose2> at(double stamp) const;

  bool empty() const { return poses_.empty(); }
  const std::string& childFrame() const { return child_frame_; }

 private:
  Trajectory poses_;  ///< ascending stamps
  std::string child_frame_;
};

/// The odometry of a bag: an Odometry topic, tf, or none. A topic whose name indicates ground truth
/// is used only if the user names it.
class BagOdometrySource {
 public:
  /// `wanted`: a topic, or "" for the only one. Throws std::runtime_error if the bag has no such
  /// topic.
  BagOdometrySource(const BagFiles& files, const BagTopics& topics, const BagTransforms& transforms,
                    std::string base_frame, const std::string& wanted);

  bool available() const { return !odom_frame_.empty() || (odometry_ && !odometry_->empty()); }
  /// odom_T_base at a time, which is given as `stamp` in s and as `time`.
  std::optional<Pose2> at(double stamp, const ros::Time& time) const;

  /// "odometry /odom", or "no odometry".
  const std::string& description() const { return description_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::string chooseTopic(const BagTopics& topics, const std::string& wanted);

  const BagTransforms& transforms_;
  std::string base_frame_;
  std::optional<BagOdometry> odometry_;
  std::string odom_frame_;  ///< in tf; "" if the odometry is not from tf
  std::string description_ = "no odometry";
  std::vector<std::string> warnings_;
};

}  // namespace kestrel
