// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/steady_timer.h>
#include <tf2_ros/buffer.h>

#include <deque>
#include <map>
#include <memory>
#include <string>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/common/transform_input.h"
#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/ros/tracker/tracker_parameters.h"
#include "kestrel_slam/tracking/tracker.h"

namespace kestrel {

/// ROS node of the tracker. Inputs: planar scans and tf. Output: tracks in a frame without jumps.
/// All work is done on the thread that serves `nh`.
class TrackerNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument if a parameter is invalid.
  TrackerNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  TrackerNode(const TrackerNode&) = delete;
  TrackerNode& operator=(const TrackerNode&) = delete;

 private:
  struct Waiting {
    kestrel_slam::PlanarScanConstPtr message;
    WaitingTime waiting;
  };

  void onScan(const kestrel_slam::PlanarScanConstPtr& message);
  void processQueue();
  bool handle(const Waiting& scan);
  void track(const kestrel_slam::PlanarScan& message, const Pose2& odom_T_base);
  void publish(const kestrel_slam::PlanarScan& message, const PlanarScan& scan,
               const Pose2& odom_T_base);
  void publishGrid(const ros::Time& stamp, const Eigen::Vector2d& center);
  void drop(const std::string& reason, const std::string& why);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);

  const TrackerNodeConfig config_;
  Tracker tracker_;
  tf2_ros::Buffer buffer_;
  TransformInput transforms_;
  std::deque<Waiting> queue_;
  std::size_t received_ = 0, used_ = 0, saturated_ = 0, shown_ = 0;
  std::map<std::string, std::size_t> dropped_;  ///< scans by reason
  std::string last_drop_;
  bool dropped_lately_ = false, saturated_lately_ = false;
  ros::Time last_stamp_, last_grid_;
  WaitingTime since_start_, since_last_;
  std::unique_ptr<SilenceWatch> watch_;
  ros::Publisher tracks_, markers_, points_, grid_;
  ros::Subscriber subscriber_;
  diagnostic_updater::Updater updater_;
  ros::SteadyTimer queue_timer_, report_timer_;
};

}  // namespace kestrel
