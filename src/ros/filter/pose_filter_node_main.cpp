// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/node_main.h"
#include "kestrel_slam/ros/filter/pose_filter_node.h"

int main(int argc, char** argv) {
  return kestrel::runNode<kestrel::PoseFilterNode>(argc, argv, "pose_filter", "pose_filter_node");
}
