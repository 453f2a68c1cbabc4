// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/hector/geotiff_node.h"

int main(int argc, char** argv) {
  using namespace kestrel;
  constexpr NodeProgram kProgram = {
      "geotiff_node", "geotiff_node",
      "writes map, trajectory and markers as a GeoTIFF with the colors of RoboCup\n"
      "Rescue: on the command savegeotiff, on the service save_geotiff, or again and again.",
      "rosrun kestrel_slam geotiff_node _map_file_path:=/tmp"};
  return runNode<GeotiffNode, GeotiffConfig>(argc, argv, kProgram);
}
