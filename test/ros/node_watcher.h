// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "patience.h"

namespace kestrel {

/// Subscribes to the diagnostics of one node and to tf.
class NodeWatcher {
 public:
  /// `node`: its full name without the leading slash.
  explicit NodeWatcher(const std::string& node,
                       const std::vector<std::string>& transform_topics = {"/tf"});

  /// Runs callbacks until `condition` is true. Returns false after `timeout_s` (Patience).
  bool waitFor(const std::function<bool()>& condition, double timeout_s = kPatience);

  /// Runs callbacks for a given time.
  void wait(double seconds) {
    waitFor([] { return false; }, seconds);
  }

  /// The next report of a diagnostics item by key; "level" and "message" are the level and the
  /// message of the item. Empty if none comes.
  std::map<std::string, std::string> report(const std::string& item);

  /// One value of the next report; empty if it is missing.
  std::string diagnosis(const std::string& item, const std::string& key) {
    return report(item)[key];
  }

  /// The last transform of a child; empty if there is none.
  geometry_msgs::TransformStamped lastTransform(const std::string& child) const;

  std::map<std::string, std::vector<geometry_msgs::TransformStamped>> transforms;  ///< by child
  std::map<std::string, std::set<std::string>> parents;                            ///< by child

 private:
  void onTransforms(const tf2_msgs::TFMessage& message);
  void onDiagnostics(const diagnostic_msgs::DiagnosticArray& message);

  std::string prefix_;
  std::vector<ros::Subscriber> subscribers_;
  std::map<std::string, std::map<std::string, std::string>> diagnostics_;
};

}  // namespace kestrel
