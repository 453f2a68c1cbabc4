// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/node_handle.h>
#include <std_msgs/String.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "kestrel_slam/ResetMapping.h"
#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/common/bounded_queue.h"
#include "kestrel_slam/ros/common/live_parameters.h"
#include "kestrel_slam/ros/mapper/diagnostics.h"
#include "kestrel_slam/ros/mapper/map_publisher.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"
#include "kestrel_slam/ros/mapper/pose_publisher.h"
#include "kestrel_slam/ros/mapper/scan_input.h"
#include "kestrel_slam/ros/mapper/session_services.h"
#include "kestrel_slam/ros/mapper/shared_mapper.h"
#include "kestrel_slam/ros/mapper/trajectory_log.h"
#include "kestrel_slam/ros/mapper/trajectory_services.h"

namespace kestrel {

/// ROS node of the mapper. Inputs: scans of a level laser, or planar scans of the projector.
/// Outputs: map, pose and tf. The interface is compatible with hector_mapping.
///
/// Uses three threads: the thread of `nh` receives scans and commands, the second matches scans,
/// and the third publishes the map.
class MapperNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument if a parameter is invalid.
  MapperNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  ~MapperNode();
  MapperNode(const MapperNode&) = delete;
  MapperNode& operator=(const MapperNode&) = delete;

 private:
  void enqueue(ReadyScan scan);
  void matchLoop();
  void handle(const ReadyScan& scan);
  void match(const ReadyScan& scan);
  std::optional<PlanarScan> planarOf(const ReadyScan& scan);
  std::optional<PlanarScan> planarOf(const kestrel_slam::PlanarScan& message);
  void drop(const std::string& reason, const std::string& sentence);
  void continueAfter(const ReadyScan& scan);
  void restart(const Pose2& map_T_base);
  void onParameters();
  void takeParameters();
  void onSession();

  void onCommand(const std_msgs::String& message);
  void onInitialPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool resetMap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  void localize();
  bool relocalize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool pauseMapping(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool restartMapping(kestrel_slam::ResetMapping::Request& request,
                      kestrel_slam::ResetMapping::Response& response);

  const MapperNodeConfig config_;  ///< as at the start
  SharedMapper mapper_;
  ScanStatistics statistics_;
  TrajectoryLog trajectory_;
  BoundedQueue<ReadyScan> queue_;

  // Only the matching thread uses these.
  ProjectionStage projection_;  ///< of a level laser
  std::set<std::string> said_;  ///< reasons of problems of the mountings
  PosePublisher pose_publisher_;
  std::size_t epoch_ = 0;
  bool was_paused_ = false;
  std::atomic<bool> placed_{false};  ///< by a user, since the last scan
  std::thread match_thread_;

  MapperNodeConfig live_config_;  ///< with what was changed since the start
  std::mutex new_parameters_mutex_;
  std::optional<SlamConfig> new_parameters_;  ///< that the matching thread does not have yet

  ros::Subscriber command_subscriber_, initial_pose_subscriber_;
  ros::ServiceServer reset_server_, pause_server_, restart_server_, relocalize_server_;
  std::unique_ptr<ScanInput> input_;
  std::unique_ptr<MapPublisher> map_publisher_;
  std::unique_ptr<TrajectoryServices> trajectory_services_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<LiveParameters> live_parameters_;
  std::unique_ptr<SessionServices> session_services_;
  std::unique_ptr<ros::AsyncSpinner> map_thread_;  ///< last: it ends before what it calls
};

}  // namespace kestrel
