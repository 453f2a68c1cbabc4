// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/mapper/mapper_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "mapper", "mapper_node",
      "matches every scan of a 2D laser with a map, publishes the pose of the vehicle\n"
      "and builds the map. Its input is the scan of a level laser, or the planar scan of\n"
      "scan_projector_node.",
      "roslaunch kestrel_slam mapper.launch"};
  return runNode<MapperNode, MapperNodeConfig>(argc, argv, kProgram);
}
