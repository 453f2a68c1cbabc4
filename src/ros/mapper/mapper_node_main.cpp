// SPDX-License-Identifier: BSD-3-Clause
#include <ros/ros.h>

#include <cstdio>
#include <exception>

#include "kestrel_slam/ros/mapper/mapper_node.h"

namespace {

/// The exit code. The last node handle to go takes the logging with it, so that a message has to be
/// written while one is left.
int run() {
  const ros::NodeHandle nh;
  try {
    const kestrel::MapperNode node(nh, ros::NodeHandle("~"));
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    ROS_FATAL("mapper_node cannot run: %s", error.what());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ros::init(argc, argv, "mapper");
    return run();
  } catch (const std::exception& error) {  // before there was any logging
    std::fprintf(stderr, "mapper_node cannot start: %s\n", error.what());
    return 1;
  }
}
