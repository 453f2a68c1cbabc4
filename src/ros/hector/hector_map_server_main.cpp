// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/hector/map_server_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "hector_map_server", "hector_map_server",
      "answers questions about the map: the distance to the next obstacle, and a place\n"
      "from which an object can be looked at.",
      "rosrun kestrel_slam hector_map_server"};
  return runNode<MapServerNode, MapServerConfig>(argc, argv, kProgram);
}
