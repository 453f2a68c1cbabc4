// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/tracker/cloud_follower.h"

#include <optional>
#include <utility>

#include "cloud_track_messages.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/messages/track_messages.h"

namespace kestrel {
namespace {

/// After this time without clouds, another lidar may take over, s.
constexpr double kSilent = 5.0;

Followed refused(const std::string& problem) {
  Followed followed;
  followed.problem = problem;
  return followed;
}

}  // namespace

CloudFollower::CloudFollower(const CloudTrackerConfig& config, std::string odom_frame)
    : odom_frame_(std::move(odom_frame)), tracker_(config) {}

Followed CloudFollower::follow(const sensor_msgs::PointCloud2& message,
                               const Eigen::Isometry3d& odom_T_lidar) {
  const LidarSweep sweep{toPointCloud(message), {}};
  if (const std::string problem = takeOver(sweep.cloud); !problem.empty()) {
    return refused(problem);
  }
  if (!tracker_.stamp()) odom_T_map_.setIdentity();
  const CloudTracker::Result& result =
      tracker_.process(sweep, odom_T_map_.inverse() * odom_T_lidar);
  if (result.used) odom_T_map_ = odom_T_lidar * result.pose.inverse();
  return resultOf(message, sweep, result);
}

Followed CloudFollower::followAlone(const sensor_msgs::PointCloud2& message,
                                    const Eigen::Isometry3d& start_T_lidar) {
  const LidarSweep sweep{toPointCloud(message), {}};
  if (const std::string problem = takeOver(sweep.cloud); !problem.empty()) {
    return refused(problem);
  }
  const auto start = tracker_.stamp() ? std::nullopt : std::optional(start_T_lidar);
  return resultOf(message, sweep, tracker_.process(sweep, start));
}

std::string CloudFollower::takeOver(const PointCloud& cloud) {
  const std::optional<double> last = tracker_.stamp();
  const bool went_back = last && cloud.stamp + kClockWentBack < *last;
  if (went_back) tracker_.reset();
  if (lidar_frame_ == cloud.frame) return "";
  if (last && !went_back && cloud.stamp - *last < kSilent) {
    return "it comes from " + cloud.frame + ", but the clouds of " + lidar_frame_ +
           " are tracked. Let only one lidar publish on this topic";
  }
  if (!lidar_frame_.empty()) tracker_.reset();
  lidar_frame_ = cloud.frame;
  return "";
}

Followed CloudFollower::resultOf(const sensor_msgs::PointCloud2& message, const LidarSweep& sweep,
                                 const CloudTracker::Result& result) {
  Followed followed;
  followed.used = result.used;
  followed.problem = result.problem;
  followed.note = sweep.cloud.time_problem;
  if (!result.used) return followed;
  localized_ = result.localized;
  followed.saturated = result.saturated;
  followed.tracks.header.frame_id = odom_frame_;
  followed.tracks.header.stamp = message.header.stamp;
  followed.tracks.saturated = static_cast<std::uint8_t>(result.saturated);
  for (const CloudTrack& track : result.tracks) {
    if (track.isShown()) followed.tracks.tracks.push_back(toMessage(track, odom_T_map_));
  }
  const Eigen::Isometry3f odom_T_lidar = (odom_T_map_ * result.pose).cast<float>();
  for (std::size_t i = 0; i < result.moving.size(); ++i) {
    if (!result.moving[i]) continue;
    const PointCloud::Point& p = sweep.cloud.points[i];
    followed.moving_points.push_back(odom_T_lidar * Eigen::Vector3f(p.x, p.y, p.z));
  }
  return followed;
}

nav_msgs::OccupancyGrid CloudFollower::grid(double radius, const ros::Time& stamp) const {
  nav_msgs::OccupancyGrid message =
      toMessage(tracker_.grid(), tracker_.pose().translation(), radius, odom_T_map_);
  message.header.frame_id = odom_frame_;
  message.header.stamp = stamp;
  return message;
}

}  // namespace kestrel
