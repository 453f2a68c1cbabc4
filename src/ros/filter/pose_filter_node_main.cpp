// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/filter/pose_filter_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "pose_filter", "pose_filter_node",
      "fuses the IMU with the poses of mapper_node and with heights, and publishes\n"
      "pose and velocity of the vehicle at the rate of the IMU.",
      "roslaunch kestrel_slam mav.launch"};
  return runNode<PoseFilterNode, PoseFilterNodeConfig>(argc, argv, kProgram);
}
