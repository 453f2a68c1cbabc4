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

/// Plays the sensors of a recording as if the vehicle flew now: every message at its time of
/// arrival, with its stamp moved to the present. `rosbag play` moves the clock instead, which it
/// can only do in steps.
class LivePlayer {
 public:
  /// Reads lasers, IMU, range finder and tf_static of a bag. Throws std::exception that says what
  /// is wrong with it.
  LivePlayer(ros::NodeHandle nh, const std::string& bag);

  bool hasImu() const { return imu_count_ > 0; }

  /// Whether somebody listens to every laser and every IMU.
  bool isHeard() const;

  /// Plays everything once, or until ROS ends. `before` sees every message just before it is
  /// published, with its new stamp.
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
