// SPDX-License-Identifier: BSD-3-Clause
#include <ros/ros.h>
#include <sensor_msgs/MultiEchoLaserScan.h>
#include <sensor_msgs/PointCloud.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/messages/sweep_messages.h"
#include "kestrel_slam/ros/common/raw_message.h"
#include "kestrel_slam/sensor/cloud_joiner.h"
#include "kestrel_slam/sensor/scan_joiner.h"

namespace kestrel {
namespace {

constexpr const char* kHelp =
    "scan_joiner: makes the messages of a scanner usable for mapper_node and\n"
    "scan_projector_node. It joins the segments or packets of a turn, uses the strongest echo of "
    "a\n"
    "MultiEchoLaserScan, and converts PointCloud to PointCloud2.\n"
    "\n"
    "Subscribes scan_parts: LaserScan, MultiEchoLaserScan, PointCloud2 or PointCloud.\n"
    "Publishes joined: LaserScan or PointCloud2, with the frame of the parts.\n"
    "\n"
    "Example: rosrun kestrel_slam scan_joiner scan_parts:=/scan_segment joined:=/scan\n";

class ScanJoinerNode {
 public:
  ScanJoinerNode() {
    subscriber_ = node_.subscribe<RawMessage>(
        "scan_parts", kQueue, [this](const boost::shared_ptr<const RawMessage>& message) {
          try {
            receive(*message);
          } catch (const std::exception& error) {
            ROS_WARN_THROTTLE(kComplainEvery, "a message on %s cannot be used: %s",
                              subscriber_.getTopic().c_str(), error.what());
          }
        });
  }

 private:
  static constexpr int kQueue = 1000;
  static constexpr double kComplainEvery = 5.0;  // s

  struct Frame {
    ScanJoiner scans;
    CloudJoiner clouds;
  };

  void receive(const RawMessage& message) {
    const std::string& type = message.type;
    if (type == "sensor_msgs/LaserScan") return addScan<sensor_msgs::LaserScan>(message);
    if (type == "sensor_msgs/MultiEchoLaserScan") {
      return addScan<sensor_msgs::MultiEchoLaserScan>(message);
    }
    if (type == "sensor_msgs/PointCloud2") return addCloud<sensor_msgs::PointCloud2>(message);
    if (type == "sensor_msgs/PointCloud") return addCloud<sensor_msgs::PointCloud>(message);
    throw std::invalid_argument("its type " + type + " is not one of a scanner");
  }

  template <typename Message>
  void addScan(const RawMessage& raw) {
    const auto message = raw.as<Message>();
    const std::string& frame = message.header.frame_id;
    for (const LaserScan& scan : frames_[frame].scans.add(fromMessage(message))) {
      if (std::isfinite(scan.stamp)) publish(toScanMessage(scan), frame);
    }
  }

  template <typename Message>
  void addCloud(const RawMessage& raw) {
    const auto message = raw.as<Message>();
    const std::string& frame = message.header.frame_id;
    for (const PointCloud& cloud : frames_[frame].clouds.add(toPointCloud(message))) {
      publish(toCloudMessage(cloud), frame);
    }
  }

  template <typename Message>
  void publish(Message message, const std::string& frame) {
    if (!publisher_) publisher_ = node_.advertise<Message>("joined", kQueue);
    message.header.frame_id = frame;
    publisher_.publish(message);
  }

  ros::NodeHandle node_;
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  std::map<std::string, Frame> frames_;  ///< some drivers send several lasers on one topic
};

}  // namespace
}  // namespace kestrel

int main(int argc, char** argv) {
  const bool help = std::any_of(argv + 1, argv + argc, [](const std::string& argument) {
    return argument == "--help" || argument == "-h";
  });
  if (help) {
    std::fputs(kestrel::kHelp, stdout);
    return 0;
  }
  ros::init(argc, argv, "scan_joiner");
  const kestrel::ScanJoinerNode node;
  ros::spin();
  return 0;
}
