// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Path.h>
#include <ros/node_handle.h>

#include <optional>
#include <string>

#include "kestrel_slam/GetRecoveryInfo.h"
#include "kestrel_slam/GetRobotTrajectory.h"
#include "kestrel_slam/ros/mapper/trajectory_log.h"

namespace kestrel {

/// The way back from the pose at `time` (or from the last pose, if there is none so late) to the
/// last pose before that was at least `radius` (m) away. Nothing if there is no such pose.
std::optional<kestrel_slam::GetRecoveryInfo::Response> wayBack(const nav_msgs::Path& path,
                                                               const ros::Time& time,
                                                               double radius);

/// The services `trajectory` and `trajectory_recovery_info` of hector_trajectory_server.
class TrajectoryServices {
 public:
  TrajectoryServices(ros::NodeHandle nh, const std::string& frame, const TrajectoryLog& trajectory);

 private:
  bool trajectory(kestrel_slam::GetRobotTrajectory::Request& request,
                  kestrel_slam::GetRobotTrajectory::Response& response);
  bool recoveryInfo(kestrel_slam::GetRecoveryInfo::Request& request,
                    kestrel_slam::GetRecoveryInfo::Response& response);

  std::string frame_;
  const TrajectoryLog& trajectory_;
  ros::ServiceServer trajectory_server_, recovery_server_;
};

}  // namespace kestrel
