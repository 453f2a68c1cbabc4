// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/tracker/tracker_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {"tracker", "tracker_node",
                                    "finds and follows people and vehicles in the planar scans of\n"
                                    "scan_projector_node, or in the clouds of a 3D lidar.",
                                    "roslaunch kestrel_slam mav.launch tracker:=true"};
  return runNode<TrackerNode, TrackerNodeConfig>(argc, argv, kProgram);
}
