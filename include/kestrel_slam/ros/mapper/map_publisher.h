// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/GetMap.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/SaveMap.h"
#include "kestrel_slam/map/map_replica.h"
#include "kestrel_slam/ros/mapper/diagnostics.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"
#include "kestrel_slam/ros/mapper/save_folder.h"
#include "kestrel_slam/ros/mapper/shared_mapper.h"
#include "kestrel_slam/ros/mapper/trajectory_log.h"

namespace kestrel {

/// Publishes the map and the trajectory, and serves the services that read the map.
///
/// It has its own callback queue, which its owner serves with a thread. It keeps a copy of the map
/// and blocks the matching only for the short time in which some changed tiles are copied. Uses a
/// wall timer, so that the last map of a replay is published even after the clock has stopped.
class MapPublisher {
 public:
  MapPublisher(const ros::NodeHandle& nh, const MapperNodeConfig& config, SharedMapper& mapper,
               TrajectoryLog& trajectory);

  /// A thread for the queue, not yet started. Whatever uses `nodeHandle()` must outlive it: roscpp
  /// does not wait for a running callback when a timer or a service is removed.
  std::unique_ptr<ros::AsyncSpinner> thread() {
    return std::make_unique<ros::AsyncSpinner>(1, &queue_);
  }

  /// A node handle whose callbacks run on the thread of this class.
  const ros::NodeHandle& nodeHandle() const { return nh_; }

  /// Time between two maps, s. Any thread may set it.
  void setPeriod(double period_s) { period_s_ = period_s; }

  /// Size of the last published map. Call it only on the thread of this class.
  MapSize mapSize() const;

 private:
  void advertise();
  void tick();
  void publishMap();
  void publishProbabilities();
  void publishUpdate();
  void refresh();
  void warnOfFullMap();
  void publishTrajectory();
  void publishGraph();
  bool dynamicMap(nav_msgs::GetMap::Request& request, nav_msgs::GetMap::Response& response);
  bool saveMap(kestrel_slam::SaveMap::Request& request, kestrel_slam::SaveMap::Response& response);
  nav_msgs::OccupancyGrid message(MapSnapshot map);
  bool isHeard() const;
  bool hasGeometryOfLastMap() const;

  ros::CallbackQueue queue_;
  ros::NodeHandle nh_;
  std::string map_frame_;
  bool with_map_service_;
  std::atomic<double> period_s_;
  SaveFolder save_folder_;
  SharedMapper& mapper_;
  TrajectoryLog& trajectory_;

  ros::Publisher graph_publisher_, loop_publisher_, submap_publisher_;
  ros::Publisher map_publisher_, update_publisher_, metadata_publisher_, trajectory_publisher_;
  ros::Publisher probability_publisher_;
  ros::ServiceServer map_server_, save_server_;
  ros::WallTimer timer_;

  std::atomic<bool> new_subscriber_{false}, wants_probabilities_{false};
  bool stands_behind_ = false;  ///< true: the thread already has low priority
  bool warned_of_full_map_ = false;
  MapReplica replica_;
  std::uint64_t map_number_ = 0;         ///< of the map in `replica_`
  std::uint64_t version_ = 0;            ///< the same
  ros::Time stamp_;                      ///< of the last scan in it
  std::uint64_t published_version_ = 0;  ///< 0: none yet
  std::uint64_t published_trajectory_ = 0;
  CellRectangle published_known_;  ///< cells of the last published map
  std::uint64_t published_graph_ = 0;
  ros::WallTime next_map_, next_update_, next_trajectory_, next_graph_;
  nav_msgs::MapMetaData last_info_;
  std::optional<LoopCounts> loops_;
};

}  // namespace kestrel
