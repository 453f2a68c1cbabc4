// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/tracker/scan_follower.h"

#include <utility>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/planar_scan_message.h"
#include "kestrel_slam/messages/track_messages.h"

namespace kestrel {

ScanFollower::ScanFollower(const TrackerConfig& config, std::string odom_frame)
    : frame_(std::move(odom_frame)), tracker_(config) {}

Followed ScanFollower::follow(const kestrel_slam::PlanarScan& message,
                              const Eigen::Isometry3d& odom_T_base) {
  PlanarScan scan = fromPlanarScanMessage(message);
  scan.time = scan.stamp;
  if (scan.stamp + kClockWentBack < last_stamp_) tracker_.reset();
  odom_T_base_ = toPose2(odom_T_base);
  const Tracker::Result& result = tracker_.process(scan, odom_T_base_);
  Followed followed;
  followed.used = result.used;
  if (!result.used) {
    followed.problem = "its stamp is not newer than that of the last scan";
    return followed;
  }
  last_stamp_ = scan.stamp;
  followed.saturated = result.saturated;
  followed.tracks = toMessage(result, frame_, message.header.stamp);
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    if (!result.is_moving[i]) continue;
    const Eigen::Vector2d end = odom_T_base_ * scan.rays[i].end.cast<double>();
    followed.moving_points.emplace_back(end.cast<float>().x(), end.cast<float>().y(), 0.0F);
  }
  return followed;
}

nav_msgs::OccupancyGrid ScanFollower::grid(double radius, const ros::Time& stamp) const {
  return toMessage(tracker_.grid(), odom_T_base_.translation(), radius, frame_, stamp);
}

}  // namespace kestrel
