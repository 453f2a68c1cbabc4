// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/trajectory_log.h"

#include <cmath>

#include "kestrel_slam/messages/conversions.h"

namespace kestrel {

using Lock = std::lock_guard<std::mutex>;

void TrajectoryLog::add(const ros::Time& stamp, const Pose2& map_T_base) {
  const Lock lock(mutex_);
  if (!entries_.empty()) {
    const Pose2 motion = entries_.back().pose.inverse() * map_T_base;
    if (motion.distance() < spacing_ * kMinDistance &&
        std::abs(motion.yaw) < spacing_ * kMinAngle) {
      return;
    }
  }
  if (entries_.size() >= kMaxPoses) halve();
  entries_.push_back({stamp, map_T_base});
  ++version_;
}

void TrajectoryLog::clear() {
  const Lock lock(mutex_);
  entries_.clear();
  spacing_ = 1.0;
  ++version_;
}

std::uint64_t TrajectoryLog::version() const {
  const Lock lock(mutex_);
  return version_;
}

nav_msgs::Path TrajectoryLog::path(const std::string& frame) const {
  nav_msgs::Path path;
  path.header.frame_id = frame;
  const Lock lock(mutex_);
  path.poses.resize(entries_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    path.poses[i].header.frame_id = frame;
    path.poses[i].header.stamp = entries_[i].stamp;
    path.poses[i].pose = toMessage(entries_[i].pose);
  }
  if (!entries_.empty()) path.header.stamp = entries_.back().stamp;
  return path;
}

void TrajectoryLog::halve() {
  const std::size_t half = entries_.size() / 2;
  for (std::size_t i = 0; i < half; ++i) entries_[i] = entries_[2 * i];
  entries_.resize(half);
  spacing_ *= 2.0;
}

}  // namespace kestrel
