// SPDX-License-Identifier: BSD-3-Clause
// Maps the scans of a level laser with kestrel_slam's pipeline, and publishes the poses.
#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/pipeline/pipeline.h"

namespace {

kestrel::PipelineConfig levelLaser() {
  kestrel::PipelineConfig config;
  config.level = true;  // no IMU
  return config;
}

class ScanPoseNode {
 public:
  ScanPoseNode() : pipeline_(levelLaser()) {
    pipeline_.on_scan = [this](const kestrel::MappedSweep& sweep) { publish(sweep); };
    pose_publisher_ = node_.advertise<geometry_msgs::PoseStamped>("pose", 10);
    scan_subscriber_ = node_.subscribe("scan", 10, &ScanPoseNode::onScan, this);
  }

 private:
  void onScan(const sensor_msgs::LaserScan& message) {
    kestrel::PipelineScan scan;
    scan.data = kestrel::fromMessage(message);
    pipeline_.addScan(scan, message.header.stamp.toSec());
  }

  void publish(const kestrel::MappedSweep& sweep) {
    const kestrel::Pose2& found = sweep.result.pose;
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = ros::Time(sweep.scan.stamp);
    pose.header.frame_id = "map";
    pose.pose = kestrel::toMessage(found);
    pose_publisher_.publish(pose);
    ROS_INFO_THROTTLE(1.0, "%s: x %.2f m, y %.2f m", toString(sweep.result.state), found.x,
                      found.y);
  }

  ros::NodeHandle node_;
  ros::Publisher pose_publisher_;
  ros::Subscriber scan_subscriber_;
  kestrel::Pipeline pipeline_;
};

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "scan_pose");
  ScanPoseNode node;
  ros::spin();
  return 0;
}
