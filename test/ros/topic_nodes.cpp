// SPDX-License-Identifier: BSD-3-Clause
#include "topic_nodes.h"

#include <ros/master.h>
#include <tf2_msgs/TFMessage.h>

namespace kestrel {
namespace {

constexpr auto kTopic = "/tf";

std::size_t count(XmlRpc::XmlRpcValue& topics, const std::string& topic) {
  for (int i = 0; i < topics.size(); ++i) {
    if (static_cast<std::string>(topics[i][0]) == topic) {
      return static_cast<std::size_t>(topics[i][1].size());
    }
  }
  return 0;
}

void ignore(const tf2_msgs::TFMessageConstPtr& /*message*/) {}

}  // namespace

TopicNodes nodesOf(const std::string& topic) {
  XmlRpc::XmlRpcValue request(ros::this_node::getName()), response, state;
  if (!ros::master::execute("getSystemState", request, response, state, false)) return {};
  return {count(state[0], topic), count(state[1], topic)};
}

TransformConnections::TransformConnections(ros::NodeHandle& nh)
    : publisher_(nh.advertise<tf2_msgs::TFMessage>(kTopic, 1)),
      subscriber_(nh.subscribe<tf2_msgs::TFMessage>(kTopic, 1, ignore)) {}

bool TransformConnections::areComplete() const {
  const TopicNodes nodes = nodesOf(kTopic);
  return subscriber_.getNumPublishers() >= nodes.publishers &&
         publisher_.getNumSubscribers() >= nodes.subscribers;
}

}  // namespace kestrel
