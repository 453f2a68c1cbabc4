// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <string>

namespace kestrel {

/// The nodes of a topic that the ROS master knows.
struct TopicNodes {
  std::size_t publishers = 0;
  std::size_t subscribers = 0;
};

TopicNodes nodesOf(const std::string& topic);

/// This node's part of /tf. A connection is made between each pair of nodes on its own, and it may
/// be the last that is made: what is sent before is lost.
class TransformConnections {
 public:
  explicit TransformConnections(ros::NodeHandle& nh);

  /// Whether this node hears all others, and all others hear it.
  bool areComplete() const;

 private:
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
