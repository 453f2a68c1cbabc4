// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <cstdio>
#include <exception>

namespace kestrel {

/// The exit code. The last node handle to go takes the logging with it, so that a message has to be
/// written while one is left.
template <typename Node>
int spinNode(const char* program) {
  const ros::NodeHandle nh;
  try {
    const Node node(nh, ros::NodeHandle("~"));
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    ROS_FATAL("%s cannot run: %s", program, error.what());
    return 1;
  }
}

/// The whole of a program with one node: 1 and one line where it cannot run.
template <typename Node>
int runNode(int argc, char** argv, const char* name, const char* program) {
  try {
    ros::init(argc, argv, name);
    return spinNode<Node>(program);
  } catch (const std::exception& error) {  // before there was any logging
    std::fprintf(stderr, "%s cannot start: %s\n", program, error.what());
    return 1;
  }
}

}  // namespace kestrel
