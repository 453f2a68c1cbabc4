#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/message_filter.h>
#include <tf2_ros/transform_listener.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/ros/node_parameters.h"
#include "kestrel_slam/ros/scan_statistics.h"

namespace kestrel_slam {

/// A scan with everything that tf says about it.
struct ReadyScan {
  sensor_msgs::LaserScanConstPtr message;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();
  std::optional<Pose2> odom_T_base;  ///< at the scan's stamp, where the node uses odometry
  std::size_t epoch = 0;             ///< grows where the stamps jump back far
};

/// Receives scans and waits for their transforms without ever blocking. Scans that cannot be used
/// are counted, and the reason is said. `nh` must be served by one thread.
class ScanInput {
 public:
  using Callback = std::function<void(ReadyScan)>;

  ScanInput(ros::NodeHandle nh, const NodeConfig& config, ScanStatistics& statistics,
            Callback on_ready);

  std::string topic() const { return subscriber_.getTopic(); }
  unsigned publisherCount() const { return subscriber_.getNumPublishers(); }

 private:
  void onScan(const sensor_msgs::LaserScanConstPtr& message);
  void onReady(const sensor_msgs::LaserScanConstPtr& message);
  void onFailure(const sensor_msgs::LaserScanConstPtr& message,
                 tf2_ros::FilterFailureReason reason);
  bool acceptable(const sensor_msgs::LaserScan& message);
  void refuse(const std::string& reason, const std::string& sentence);
  void noticeJump(const ros::Time& stamp);
  bool needsTransform(const sensor_msgs::LaserScan& message) const;
  void explainWaiting(const sensor_msgs::LaserScan& message);
  std::string missingTransform(const sensor_msgs::LaserScan& message) const;
  void warnOfOtherParent(const ros::Time& stamp) const;
  ReadyScan lookUp(const sensor_msgs::LaserScanConstPtr& message) const;

  NodeConfig config_;
  ScanStatistics& statistics_;
  Callback on_ready_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
  tf2_ros::MessageFilter<sensor_msgs::LaserScan> filter_;
  ros::Subscriber subscriber_;

  ros::Time last_stamp_;
  std::size_t epoch_ = 0;
  ros::WallTime waiting_since_;  ///< when scans began to lack a transform; zero: they do not
};

}  // namespace kestrel_slam
