// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/Range.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <map>
#include <string>
#include <variant>
#include <vector>

namespace kestrel {

using LiveMessage =
    std::variant<sensor_msgs::LaserScanPtr, sensor_msgs::ImuPtr, sensor_msgs::RangePtr>;

/// Plays the sensors of a recording in real time. Every message is published at its time of
/// arrival, with its stamp shifted to the current time. `rosbag play` sets the clock instead, which
/// is only possible in steps.
class LivePlayer {
 public:
  /// Reads lasers, IMU, range finder and tf_static of a bag. Throws std::exception with the reason
  /// if the bag cannot be used.
  LivePlayer(ros::NodeHandle nh, const std::string& bag);

  bool hasImu() const { return imu_count_ > 0; }

  /// True if every laser and every IMU has a subscriber.
  bool isHeard() const;

  /// Plays everything once, or until ROS ends. `before` is called for every message just before it
  /// is published, with its new stamp.
  void play(const std::function<void(const LiveMessage&)>& before);

 private:
  struct Event {
    ros::Time arrival;
    LiveMessage message;
    ros::Publisher publisher;
  };

  template <typename Message>
  void add(const ros::Time& arrival, const std::string& topic,
           const boost::shared_ptr<Message>& message);
  void publishMountings(const tf2_msgs::TFMessage& mountings);

  ros::NodeHandle nh_;
  std::map<std::string, ros::Publisher> publishers_;
  ros::Publisher mounting_publisher_;
  std::vector<Event> events_;
  std::size_t scan_count_ = 0, imu_count_ = 0;
};

}  // namespace kestrel
