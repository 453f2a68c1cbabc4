// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/projector/scan_projector_node.h"

int main(int argc, char** argv) {
  return kestrel::runNode<kestrel::ScanProjectorNode>(argc, argv, "scan_projector",
                                                      "scan_projector_node");
}
