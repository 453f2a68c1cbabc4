// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/node_program.h"

namespace kestrel {

/// Runs the node and returns the exit code. ROS logging stops when the last node handle is
/// destroyed. Therefore `nh` must exist until the error is logged.
template <typename Node>
int spinNode(const char* program, const std::string& unused_arguments) {
  const ros::NodeHandle nh;
  if (!unused_arguments.empty()) ROS_WARN("%s", unused_arguments.c_str());
  try {
    const Node node(nh, ros::NodeHandle("~"));
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    ROS_FATAL("%s cannot run: %s", program, error.what());
    return 1;
  }
}

/// The main function of a node with the parameters of `Config`. Exit code: 0, or 1 with a one-line
/// error message.
template <typename Node, typename Config>
int runNode(int argc, char** argv, const NodeProgram& program) {
  Config defaults;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (const auto answer = answerTo(arguments, program, parametersOf(defaults))) {
    std::fputs(answer->c_str(), stdout);
    return 0;
  }
  try {
    ros::init(argc, argv, program.node);  // takes the remappings out of the arguments
    const std::string unused = unusedArguments(argc, argv);
    return spinNode<Node>(program.program, unused);
  } catch (const std::exception& error) {  // error before ROS logging is available
    std::fprintf(stderr, "%s cannot start: %s\n", program.program, error.what());
    return 1;
  }
}

}  // namespace kestrel
