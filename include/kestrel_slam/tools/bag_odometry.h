#pragma once

#include <rosbag/bag.h>

#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/tools/bag_transforms.h"

namespace kestrel_slam {

/// The poses of a nav_msgs/Odometry topic, interpolated.
class BagOdometry {
 public:
  BagOdometry(const rosbag::Bag& bag, const std::string& topic);

  /// odom_T_child at `stamp` (s), between two messages at most kMaxGap apart.
  std::optional<Pose2> at(double stamp) const;

  bool empty() const { return poses_.empty(); }
  const std::string& childFrame() const { return child_frame_; }

  static constexpr double kMaxGap = 0.5;  ///< s

 private:
  struct Entry {
    double stamp;
    Pose2 pose;
  };

  std::vector<Entry> poses_;  ///< ascending stamps
  std::string child_frame_;
};

/// A ROS time in seconds, rounded once: the double that the same decimals give when they are read.
double toSeconds(const ros::Time& time);

}  // namespace kestrel_slam
