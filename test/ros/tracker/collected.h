// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>

#include <string>
#include <vector>

#include "patience.h"

namespace kestrel {

/// All messages of a topic.
template <typename Message>
class Collected {
 public:
  Collected(ros::NodeHandle& nh, const std::string& topic)
      : subscriber_(nh.subscribe<Message>(
            topic, 200, [this](const boost::shared_ptr<const Message>& m) { all.push_back(*m); })) {
  }
  bool isConnected() const { return subscriber_.getNumPublishers() > 0; }
  std::vector<Message> all;

 private:
  ros::Subscriber subscriber_;
};

inline void spinFor(double seconds) {
  Patience patience(seconds);
  while (!patience.isOver()) {
    ros::spinOnce();
    ros::WallDuration(0.002).sleep();
  }
}

}  // namespace kestrel
