// SPDX-License-Identifier: BSD-3-Clause
// A node of another package that matches scans of a level laser and publishes the pose.
#include <geometry_msgs/PoseStamped.h>
#include <ros/ros.h>
#include <sensor_msgs/LaserScan.h>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/sensor/scan_projector.h"

class ScanPoseNode {
 public:
  ScanPoseNode() {
    pose_publisher_ = node_.advertise<geometry_msgs::PoseStamped>("pose", 10);
    scan_subscriber_ = node_.subscribe("scan", 10, &ScanPoseNode::onScan, this);
  }

 private:
  void onScan(const sensor_msgs::LaserScan& message) {
    const auto projection =
        projector_.project(kestrel_slam::fromMessage(message), Eigen::Isometry3d::Identity());
    if (projection.error != kestrel_slam::ScanError::kNone) return;
    const kestrel_slam::MapperResult result = mapper_.process(projection.scan);
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = message.header.stamp;
    pose.header.frame_id = "map";
    pose.pose = kestrel_slam::toMessage(result.pose);
    pose_publisher_.publish(pose);
    ROS_INFO_THROTTLE(1.0, "%s: x %.2f m, y %.2f m", toString(result.state), result.pose.x,
                      result.pose.y);
  }

  ros::NodeHandle node_;
  ros::Publisher pose_publisher_;
  ros::Subscriber scan_subscriber_;
  kestrel_slam::ScanProjector projector_{kestrel_slam::ProjectorConfig()};
  kestrel_slam::Mapper mapper_{kestrel_slam::MapperConfig()};
};

int main(int argc, char** argv) {
  ros::init(argc, argv, "scan_pose");
  ScanPoseNode node;
  ros::spin();
  return 0;
}
