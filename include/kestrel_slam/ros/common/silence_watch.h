// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {

/// A topic that a node needs.
struct NeededTopic {
  std::string name;  ///< resolved, with a leading slash
  std::string type;  ///< "sensor_msgs/LaserScan"
};

/// What is known about the other nodes when no message arrives.
struct RosGraph {
  std::map<std::string, std::string> published;  ///< type by topic, as the master knows it
  unsigned connected = 0;                        ///< publishers that are connected to this node
  bool clock_is_missing = false;                 ///< use_sim_time is set, but /clock never came
};

/// Why no message arrives on any of the topics, in less than 200 characters with names of usual
/// length. `parameter`: the parameter with the name of the topic.
std::string silenceReason(const std::vector<NeededTopic>& topics, const std::string& parameter,
                          const RosGraph& graph);

/// True if ROS time is simulated and no /clock has arrived yet. Then it stands still.
bool clockIsMissing();

/// Says why no message arrives on the topics of an input: soon after the start and then rarely.
/// Measures wall time.
class SilenceWatch {
 public:
  /// `what`: "scan". `parameter`: "~scan_topic".
  SilenceWatch(std::string what, std::vector<NeededTopic> topics, std::string parameter);

  /// Call it about once per second with the time since the last message, or since the start.
  /// Returns the sentence for the diagnostics, empty if messages arrive. It is logged when it is
  /// due.
  std::string check(double silent_s, unsigned connected);

  static constexpr double kSilentAfter = 2.0;   ///< s; the sentence comes within 3 s
  static constexpr double kRemindEvery = 30.0;  ///< s

 private:
  std::string what_, parameter_;
  std::vector<NeededTopic> topics_;
  std::string reason_;  ///< as found out last
  WallThrottle throttle_{kRemindEvery};
};

}  // namespace kestrel
