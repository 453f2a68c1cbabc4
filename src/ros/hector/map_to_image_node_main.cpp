// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/hector/map_image_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "map_to_image_node", "map_to_image_node",
      "publishes the map as an image, whole and around the vehicle, for a slow\n"
      "radio link: raw and as PNG.",
      "rosrun kestrel_slam map_to_image_node"};
  return runNode<MapImageNode, MapImageConfig>(argc, argv, kProgram);
}
