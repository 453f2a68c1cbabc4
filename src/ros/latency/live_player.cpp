// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/latency/live_player.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <stdexcept>

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 1000;
constexpr double kLeadTime = 0.5;  // s from play() to the first message

}  // namespace

template <typename Message>
void LivePlayer::add(const ros::Time& arrival, const std::string& topic,
                     const boost::shared_ptr<Message>& message) {
  auto publisher = publishers_.find(topic);
  if (publisher == publishers_.end()) {
    publisher = publishers_.emplace(topic, nh_.advertise<Message>(topic, kQueue)).first;
  }
  events_.push_back({arrival, message, publisher->second});
}

LivePlayer::LivePlayer(ros::NodeHandle nh, const std::string& bag_path) : nh_(nh) {
  const rosbag::Bag bag(bag_path);
  tf2_msgs::TFMessage mountings;
  for (const rosbag::MessageInstance& instance : rosbag::View(bag)) {
    const ros::Time& arrival = instance.getTime();
    const std::string& topic = instance.getTopic();
    if (const auto scan = instance.instantiate<sensor_msgs::LaserScan>()) {
      add(arrival, topic, scan);
      ++scan_count_;
    } else if (const auto imu = instance.instantiate<sensor_msgs::Imu>()) {
      add(arrival, topic, imu);
      ++imu_count_;
    } else if (const auto range = instance.instantiate<sensor_msgs::Range>()) {
      add(arrival, topic, range);
    } else if (topic == "/tf_static") {
      const auto transforms = instance.instantiate<tf2_msgs::TFMessage>();
      if (!transforms) continue;
      mountings.transforms.insert(mountings.transforms.end(), transforms->transforms.begin(),
                                  transforms->transforms.end());
    }
  }
  if (scan_count_ == 0) throw std::runtime_error("the bag has no sensor_msgs/LaserScan");
  publishMountings(mountings);
}

void LivePlayer::publishMountings(const tf2_msgs::TFMessage& mountings) {
  constexpr bool kLatched = true;
  mounting_publisher_ = nh_.advertise<tf2_msgs::TFMessage>("/tf_static", 1, kLatched);
  mounting_publisher_.publish(mountings);
}

bool LivePlayer::isHeard() const {
  for (const Event& event : events_) {
    const bool is_needed = !std::holds_alternative<sensor_msgs::RangePtr>(event.message);
    if (is_needed && event.publisher.getNumSubscribers() == 0) return false;
  }
  return true;
}

void LivePlayer::play(const std::function<void(const LiveMessage&)>& before) {
  const ros::WallTime start = ros::WallTime::now() + ros::WallDuration(kLeadTime);
  const ros::Time first = events_.front().arrival;
  const ros::Duration shift = ros::Time(start.sec, start.nsec) - first;
  for (const Event& event : events_) {
    if (!ros::ok()) return;
    ros::WallTime::sleepUntil(start + ros::WallDuration((event.arrival - first).toSec()));
    std::visit(
        [&](const auto& message) {
          message->header.stamp += shift;
          before(event.message);
          event.publisher.publish(message);
        },
        event.message);
  }
}

}  // namespace kestrel
