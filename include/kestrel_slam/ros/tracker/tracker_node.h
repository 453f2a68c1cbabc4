// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/node_handle.h>
#include <ros/steady_timer.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_broadcaster.h>

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/common/transform_input.h"
#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/ros/common/wall_throttle.h"
#include "kestrel_slam/ros/tracker/cloud_follower.h"
#include "kestrel_slam/ros/tracker/scan_follower.h"
#include "kestrel_slam/ros/tracker/tracker_parameters.h"

namespace kestrel {

/// ROS node of the tracker. Inputs: planar scans or clouds of a 3D lidar, and tf. Output: tracks in
/// a frame without jumps. All work is done on the thread that serves `nh`.
class TrackerNode {
 public:
  /// `nh` must be served by one thread. Throws std::invalid_argument if a parameter is invalid.
  TrackerNode(ros::NodeHandle nh, ros::NodeHandle private_nh);
  TrackerNode(const TrackerNode&) = delete;
  TrackerNode& operator=(const TrackerNode&) = delete;

 private:
  /// A scan or a cloud that waits for its transform.
  struct Waiting {
    std_msgs::Header header;
    /// Tracks with it, given the transform from the reference frame.
    std::function<Followed(const Eigen::Isometry3d&)> follow;
    WaitingTime waiting;
  };

  template <typename Message>
  void subscribe(ros::NodeHandle nh, const std::string& topic);
  void onMessage(const boost::shared_ptr<const kestrel_slam::PlanarScan>& message);
  void onMessage(const boost::shared_ptr<const sensor_msgs::PointCloud2>& message);
  void choose(bool clouds);
  bool accept(const std_msgs::Header& header);
  void push(Waiting data, std::size_t most);
  void processQueue();
  bool handle(const Waiting& data);
  const std::string& referenceFrame(const std::string& frame) const;
  void finish(const std_msgs::Header& header, const Followed& followed);
  void publish(const Followed& followed);
  void publishOdometry(const std_msgs::Header& header, const Eigen::Isometry3d& base_T_lidar);
  void publishGrid(const ros::Time& stamp);
  void drop(const std::string& reason, const std::string& why);
  bool isNews(std::string problem);
  void report(diagnostic_updater::DiagnosticStatusWrapper& status);
  unsigned publisherCount() const;

  const TrackerNodeConfig config_;
  ScanFollower scans_;
  CloudFollower clouds_;
  enum class Input { kUndecided, kScans, kClouds } input_ = Input::kUndecided;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformBroadcaster broadcaster_;
  TransformInput transforms_;
  std::deque<Waiting> queue_;
  std::size_t received_ = 0, used_ = 0, saturated_ = 0, unlocalized_ = 0, shown_ = 0;
  std::map<std::string, std::size_t> dropped_;     ///< scans or clouds by reason
  std::map<std::string, WallThrottle> throttles_;  ///< of the log, by problem
  std::string last_drop_, limit_;                  ///< since the last report
  std::string note_;
  bool saturated_lately_ = false;
  ros::Time last_grid_;
  WaitingTime since_start_, since_last_;
  std::unique_ptr<SilenceWatch> watch_;
  ros::Publisher tracks_, markers_, points_, grid_;
  std::map<bool, ros::Subscriber> subscribers_;  ///< true: of clouds
  diagnostic_updater::Updater updater_;
  ros::SteadyTimer queue_timer_, report_timer_;
};

}  // namespace kestrel
