// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/message_traits.h>
#include <ros/node_handle.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/message_filter.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "kestrel_slam/PlanarScan.h"
#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/ros/common/silence_watch.h"
#include "kestrel_slam/ros/common/transform_input.h"
#include "kestrel_slam/ros/mapper/mapper_parameters.h"
#include "kestrel_slam/ros/mapper/scan_statistics.h"

namespace kestrel {

/// A received message, never copied: a laser scan or a planar scan of the projector. One of the
/// pointers is null.
struct ScanMessage {
  sensor_msgs::LaserScanConstPtr laser_scan;
  kestrel_slam::PlanarScanConstPtr planar_scan;
};

/// A scan that may have to wait for its transforms.
struct ReceivedScan {
  ScanMessage message;
  std::string frame;  ///< the frame to transform, without a leading slash
  ros::Time stamp;
};

/// A scan with its transforms from tf.
struct ReadyScan {
  ScanMessage message;
  ros::Time stamp;
  Eigen::Isometry3d base_T_laser = Eigen::Isometry3d::Identity();  ///< not used for planar scans
  std::optional<Pose2> odom_T_base;  ///< at the scan's stamp, if the node uses odometry
  std::size_t epoch = 0;             ///< increases when the stamps jump back far
};

}  // namespace kestrel

namespace ros::message_traits {

// Required by the message filter of tf2.
template <>
struct FrameId<kestrel::ReceivedScan> {
  static std::string value(const kestrel::ReceivedScan& scan) { return scan.frame; }
};
template <>
struct TimeStamp<kestrel::ReceivedScan> {
  static ros::Time value(const kestrel::ReceivedScan& scan) { return scan.stamp; }
};

}  // namespace ros::message_traits

namespace kestrel {

/// Receives laser scans or planar scans and waits for their transforms without blocking. Unusable
/// scans are counted, and the reason is logged. `nh` must be served by one thread.
class ScanInput {
 public:
  using Callback = std::function<void(ReadyScan)>;

  ScanInput(ros::NodeHandle nh, const MapperNodeConfig& config, ScanStatistics& statistics,
            Callback on_ready);

  std::string topic() const { return subscriber_.getTopic(); }
  NeededTopic neededTopic() const;
  unsigned publisherCount() const { return subscriber_.getNumPublishers(); }

 private:
  using ReceivedScanPtr = boost::shared_ptr<const ReceivedScan>;

  void onLaserScan(const sensor_msgs::LaserScanConstPtr& message);
  void onPlanarScan(const kestrel_slam::PlanarScanConstPtr& message);
  void receive(const ReceivedScan& scan, std::size_t beams);
  void onReady(const ReceivedScanPtr& scan);
  void handOver(const ReceivedScan& scan);
  void onFailure(const ReceivedScanPtr& scan, tf2_ros::FilterFailureReason reason);
  bool acceptable(const ReceivedScan& scan, std::size_t beams);
  bool isRepeated(const ReceivedScan& scan) const;
  void refuse(const std::string& reason, const std::string& sentence);
  void noticeJump(const ros::Time& stamp);
  bool needsTransform(const ReceivedScan& scan) const;
  std::string laserFrameOf(const ReceivedScan& scan) const;
  bool hasOtherClock(const ReceivedScan& scan) const;
  double clocksApart(const std::string& a, const std::string& b, const ros::Time& stamp) const;
  void explainWaiting(const ReceivedScan& scan);
  std::string missingTransform(const ReceivedScan& scan) const;
  ReadyScan lookUp(const ReceivedScan& scan) const;

  MapperNodeConfig config_;
  ScanStatistics& statistics_;
  Callback on_ready_;
  ros::Time last_stamp_;
  std::map<std::string, ros::Time> last_stamps_;  ///< by frame
  std::size_t epoch_ = 0;
  ros::WallTime waiting_since_;  ///< start of waiting for a transform; zero: not waiting

  tf2_ros::Buffer buffer_;
  TransformInput transforms_;
  tf2_ros::MessageFilter<ReceivedScan> filter_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
