// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "kestrel_slam/SaveMap.h"
#include "kestrel_slam/ros/mapper/diagnostics.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"
#include "kestrel_slam/ros/mapper/shared_mapper.h"
#include "kestrel_slam/ros/mapper/trajectory_log.h"

namespace kestrel {

/// Publishes map and trajectory, and answers the services that read the map.
///
/// All of it runs on a queue and a thread of its own: the only thing it shares with the matching is
/// the short lock while the map is copied. Driven by wall time, so that the last map of a replay
/// is published after the clock has stopped.
class MapPublisher {
 public:
  MapPublisher(const ros::NodeHandle& nh, const MapperNodeConfig& config, SharedMapper& mapper,
               TrajectoryLog& trajectory);
  ~MapPublisher();

  /// A handle whose timers run on this thread.
  const ros::NodeHandle& nodeHandle() const { return nh_; }

  /// Of the last map that was published. To be called on this thread.
  MapSize mapSize() const;

 private:
  void advertise();
  void tick();
  void publishMap();
  void publishTrajectory();
  bool dynamicMap(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool saveMap(kestrel_slam::SaveMap::Request& request, kestrel_slam::SaveMap::Response& response);
  nav_msgs::OccupancyGrid messageOf(MapCopy copy);

  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  std::string map_frame_;
  bool with_map_service_;
  ros::WallDuration period_;
  SharedMapper& mapper_;
  TrajectoryLog& trajectory_;

  ros::Publisher map_publisher_, metadata_publisher_, trajectory_publisher_;
  ros::ServiceServer map_server_, save_server_;
  ros::WallTimer timer_;

  std::atomic<bool> new_subscriber_{false};
  bool stands_behind_ = false;           ///< the thread has its low priority
  std::uint64_t published_version_ = 0;  ///< 0: none yet
  std::uint64_t published_trajectory_ = 0;
  ros::WallTime next_map_, next_trajectory_;
  nav_msgs::MapMetaData last_info_;
  std::unique_ptr<ros::AsyncSpinner> spinner_;
};

}  // namespace kestrel
