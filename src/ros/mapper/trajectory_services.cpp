// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/trajectory_services.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

using geometry_msgs::PoseStamped;

double distanceBetween(const PoseStamped& a, const PoseStamped& b) {
  return std::hypot(a.pose.position.x - b.pose.position.x, a.pose.position.y - b.pose.position.y);
}

}  // namespace

std::optional<kestrel_slam::GetRecoveryInfo::Response> wayBack(const nav_msgs::Path& path,
                                                               const ros::Time& time,
                                                               double radius) {
  const std::vector<PoseStamped>& poses = path.poses;
  if (poses.empty()) return std::nullopt;
  const auto at = std::find_if(poses.begin(), poses.end() - 1,
                               [&](const PoseStamped& pose) { return pose.header.stamp >= time; });
  const auto back = std::make_reverse_iterator(at + 1);
  const auto entry = std::find_if(back, poses.rend(), [&](const PoseStamped& pose) {
    return distanceBetween(pose, *at) >= radius;
  });
  if (entry == poses.rend()) return std::nullopt;
  kestrel_slam::GetRecoveryInfo::Response response;
  response.req_pose = *at;
  response.radius_entry_pose = *entry;
  nav_msgs::Path& way = response.trajectory_radius_entry_pose_to_req_pose;
  way.header = at->header;
  way.poses.assign(back, entry + 1);
  return response;
}

TrajectoryServices::TrajectoryServices(ros::NodeHandle nh, const std::string& frame,
                                       const TrajectoryLog& trajectory)
    : frame_(frame), trajectory_(trajectory) {
  trajectory_server_ = nh.advertiseService("trajectory", &TrajectoryServices::trajectory, this);
  recovery_server_ =
      nh.advertiseService("trajectory_recovery_info", &TrajectoryServices::recoveryInfo, this);
}

bool TrajectoryServices::trajectory(kestrel_slam::GetRobotTrajectory::Request&,
                                    kestrel_slam::GetRobotTrajectory::Response& response) {
  response.trajectory = trajectory_.path(frame_);
  return true;
}

/// As in hector_trajectory_server, the call fails if there is no way back.
bool TrajectoryServices::recoveryInfo(kestrel_slam::GetRecoveryInfo::Request& request,
                                      kestrel_slam::GetRecoveryInfo::Response& response) {
  const auto found =
      wayBack(trajectory_.path(frame_), request.request_time, request.request_radius);
  if (found) response = *found;
  if (!found) {
    ROS_WARN(
        "trajectory_recovery_info: the vehicle was never %.2f m away from the pose that was "
        "asked for.",
        request.request_radius);
  }
  return found.has_value();
}

}  // namespace kestrel
