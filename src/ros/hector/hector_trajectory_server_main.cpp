// SPDX-License-Identifier: BSD-3-Clause
#include <ros/ros.h>

/// For launch files of hector_slam: the mapper does what this node did there. It keeps running,
/// because launch files may require it.
int main(int argc, char** argv) {
  ros::init(argc, argv, "hector_trajectory_server");
  const ros::NodeHandle nh;
  ROS_WARN(
      "hector_trajectory_server is not needed: mapper_node has the topic and the service "
      "trajectory, and the service trajectory_recovery_info. Remove this node.");
  ros::spin();
  return 0;
}
