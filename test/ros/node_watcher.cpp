// SPDX-License-Identifier: BSD-3-Clause
#include "node_watcher.h"

#include <ros/callback_queue.h>

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;

}  // namespace

NodeWatcher::NodeWatcher(const std::string& node, const std::vector<std::string>& transform_topics)
    : prefix_(node + ": ") {
  ros::NodeHandle nh;
  subscribers_ = {nh.subscribe("/diagnostics", kQueue, &NodeWatcher::onDiagnostics, this)};
  for (const std::string& topic : transform_topics)
    subscribers_.push_back(nh.subscribe(topic, kQueue, &NodeWatcher::onTransforms, this));
}

bool NodeWatcher::waitFor(const std::function<bool()>& condition, double timeout_s) {
  Patience patience(timeout_s);
  while (ros::ok()) {
    ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.002));
    if (condition()) return true;
    if (patience.isOver()) return false;
  }
  return false;
}

std::map<std::string, std::string> NodeWatcher::report(const std::string& item) {
  diagnostics_.clear();
  waitFor([&] { return diagnostics_.count(item) > 0; });
  return diagnostics_[item];
}

geometry_msgs::TransformStamped NodeWatcher::lastTransform(const std::string& child) const {
  const auto known = transforms.find(child);
  return known == transforms.end() ? geometry_msgs::TransformStamped() : known->second.back();
}

void NodeWatcher::onTransforms(const tf2_msgs::TFMessage& message) {
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    transforms[transform.child_frame_id].push_back(transform);
    parents[transform.child_frame_id].insert(transform.header.frame_id);
  }
}

/// Items are named "<node>: <item>".
void NodeWatcher::onDiagnostics(const diagnostic_msgs::DiagnosticArray& message) {
  for (const diagnostic_msgs::DiagnosticStatus& status : message.status) {
    if (status.name.compare(0, prefix_.size(), prefix_) != 0) continue;
    auto& item = diagnostics_[status.name.substr(prefix_.size())];
    item.clear();
    item["level"] = std::to_string(static_cast<int>(status.level));
    item["message"] = status.message;
    for (const diagnostic_msgs::KeyValue& pair : status.values) item[pair.key] = pair.value;
  }
}

}  // namespace kestrel
