// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/common/silence_watch.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <ros/time.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "kestrel_slam/ros/common/names.h"

namespace kestrel {
namespace {

constexpr std::size_t kMaxList = 80;  // characters of a list of names

/// Outputs of this package. They have types of sensors, but are none.
bool isOutput(const std::string& topic) {
  for (const std::string name : {"/slam_cloud", "/planar_scan_view", "/imu/bias"}) {
    const bool fits = topic.size() >= name.size();
    if (fits && topic.compare(topic.size() - name.size(), name.size(), name) == 0) return true;
  }
  return false;
}

/// The published topics of the needed types.
std::vector<std::string> candidates(const std::vector<NeededTopic>& topics, const RosGraph& graph) {
  std::vector<std::string> names;
  for (const auto& [name, type] : graph.published) {
    const auto fits = [&type = type](const NeededTopic& topic) { return topic.type == type; };
    const bool has_type = std::any_of(topics.begin(), topics.end(), fits);
    if (has_type && !isOutput(name)) names.push_back(name);
  }
  return names;
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    const std::string item = clippedName(name);
    if (!list.empty() && list.size() + item.size() > kMaxList) return list + ", ...";
    list += (list.empty() ? "" : ", ") + item;
  }
  return list;
}

std::string namesOf(const std::vector<NeededTopic>& topics) {
  std::vector<std::string> names;
  for (const NeededTopic& topic : topics) names.push_back(topic.name);
  return listOf(names);
}

/// "LaserScan" for "sensor_msgs/LaserScan".
std::string shortType(const std::string& type) { return type.substr(type.rfind('/') + 1); }

/// The topics as the master knows them. Does not wait for a master.
std::map<std::string, std::string> publishedTopics() {
  XmlRpc::XmlRpcValue request, response, payload;
  request[0] = ros::this_node::getName();
  request[1] = "";
  std::map<std::string, std::string> published;
  if (!ros::master::execute("getPublishedTopics", request, response, payload, false)) {
    return published;
  }
  for (int i = 0; i < payload.size(); ++i) {
    published[std::string(payload[i][0])] = std::string(payload[i][1]);
  }
  return published;
}

}  // namespace

std::string silenceReason(const std::vector<NeededTopic>& topics, const std::string& parameter,
                          const RosGraph& graph) {
  if (graph.clock_is_missing) {
    return "use_sim_time is true, but nobody publishes /clock. Play the bag with --clock, or set "
           "use_sim_time to false";
  }
  bool is_published = false;
  for (const NeededTopic& topic : topics) {
    const auto found = graph.published.find(topic.name);
    if (found == graph.published.end()) continue;
    is_published = true;
    if (found->second != topic.type) {
      return clippedName(topic.name) + " has the type " + clippedName(found->second) + ", not " +
             topic.type + "; set " + parameter + " to another topic";
    }
  }
  if (graph.connected > 0) {
    return std::to_string(graph.connected) +
           " publisher(s), but no message; check the node that sends it";
  }
  if (is_published) {
    return "its publisher cannot be reached; check ROS_IP and ROS_HOSTNAME on both computers";
  }
  const std::vector<std::string> others = candidates(topics, graph);
  if (!others.empty()) {
    return "nobody publishes it; set " + parameter + " to one of: " + listOf(others);
  }
  return "nobody publishes it, and no other " + shortType(topics.front().type) +
         "; check that the driver runs";
}

bool clockIsMissing() { return ros::Time::isSimTime() && ros::Time::now().isZero(); }

SilenceWatch::SilenceWatch(std::string what, std::vector<NeededTopic> topics, std::string parameter)
    : what_(std::move(what)), parameter_(std::move(parameter)), topics_(std::move(topics)) {}

std::string SilenceWatch::check(double silent_s, unsigned connected) {
  if (silent_s < kSilentAfter || topics_.empty()) return "";
  const bool is_due = throttle_.due();
  if (is_due) {
    reason_ = silenceReason(topics_, parameter_, {publishedTopics(), connected, clockIsMissing()});
  }
  const std::string sentence = "no " + what_ + " on " + namesOf(topics_) + " for " +
                               std::to_string(static_cast<int>(silent_s)) + " s: " + reason_;
  if (is_due) ROS_WARN("There is %s.", sentence.c_str());
  return sentence;
}

}  // namespace kestrel
