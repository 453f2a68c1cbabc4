#include "kestrel_slam/tools/bag_odometry.h"

#include <nav_msgs/Odometry.h>
#include <rosbag/view.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace kestrel_slam {
namespace {

Pose2 toPose2(const geometry_msgs::Pose& pose) {
  const auto& q = pose.orientation;
  const double yaw =
      std::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
  return {pose.position.x, pose.position.y, yaw};
}

}  // namespace

double toSeconds(const ros::Time& time) {
  // Through text: sec + 1e-9 * nsec rounds twice, and misses the double that a log has by one bit.
  char text[32];
  std::snprintf(text, sizeof text, "%u.%09u", time.sec, time.nsec);
  return std::strtod(text, nullptr);
}

BagOdometry::BagOdometry(const rosbag::Bag& bag, const std::string& topic) {
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  for (const rosbag::MessageInstance& message : view) {
    const auto odometry = message.instantiate<nav_msgs::Odometry>();
    if (!odometry) {
      throw std::runtime_error("topic " + topic + " is a " + message.getDataType() +
                               " of an unknown version, not nav_msgs/Odometry; choose another one");
    }
    const Pose2 pose = toPose2(odometry->pose.pose);
    if (!pose.isFinite()) continue;
    child_frame_ = withoutSlash(odometry->child_frame_id);
    poses_.push_back({toSeconds(odometry->header.stamp), pose});
  }
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const Entry& a, const Entry& b) { return a.stamp < b.stamp; });
}

std::optional<Pose2> BagOdometry::at(double stamp) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp,
                                      [](const Entry& e, double t) { return e.stamp < t; });
  if (after == poses_.end()) return std::nullopt;
  if (after->stamp == stamp) return after->pose;
  if (after == poses_.begin()) return std::nullopt;
  const Entry &a = *std::prev(after), &b = *after;
  const double gap = b.stamp - a.stamp;
  if (gap > kMaxGap) return std::nullopt;
  const double f = (stamp - a.stamp) / gap;
  return Pose2(a.pose.x + f * (b.pose.x - a.pose.x), a.pose.y + f * (b.pose.y - a.pose.y),
               a.pose.theta + f * normalizeAngle(b.pose.theta - a.pose.theta));
}

}  // namespace kestrel_slam
