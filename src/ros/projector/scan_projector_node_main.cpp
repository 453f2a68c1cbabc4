// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/projector/scan_projector_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "scan_projector", "scan_projector_node",
      "turns the scans of a tilted laser, or the clouds of a 3D lidar, into\n"
      "horizontal scans for mapper_node. It uses the attitude from an IMU, and the height from a\n"
      "range finder if there is one.",
      "roslaunch kestrel_slam mav.launch"};
  return runNode<ScanProjectorNode, ProjectorNodeConfig>(argc, argv, kProgram);
}
