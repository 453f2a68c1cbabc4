// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/sweep_input.h"

#include <ros/console.h>

#include <stdexcept>
#include <utility>

#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/names.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 5;
constexpr double kComplainEvery = 5.0;  // s

}  // namespace

SweepInput::SweepInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                       ProjectorStatistics& statistics, Callback on_sweep)
    : max_beams_(static_cast<std::size_t>(config.slam.projector.beams.max_beams)),
      statistics_(statistics),
      on_sweep_(std::move(on_sweep)) {
  for (const std::string& name : splitNames(config.scan_topics)) {
    const std::string topic = nh.resolveName(name);
    needed_.push_back({topic, ros::message_traits::datatype<sensor_msgs::LaserScan>()});
    subscribers_.push_back(subscribeGuarded<sensor_msgs::LaserScan>(
        nh, name, kQueue,
        [this, topic](const sensor_msgs::LaserScanConstPtr& message) { onScan(message, topic); },
        refusalOf(topic)));
  }
  if (config.cloud_topic.empty()) return;
  const std::string topic = nh.resolveName(config.cloud_topic);
  needed_.push_back({topic, ros::message_traits::datatype<sensor_msgs::PointCloud2>()});
  subscribers_.push_back(subscribeGuarded<sensor_msgs::PointCloud2>(
      nh, config.cloud_topic, kQueue,
      [this, topic](const sensor_msgs::PointCloud2ConstPtr& message) { onCloud(message, topic); },
      refusalOf(topic)));
}

/// What is done with a message whose stamp cannot be right.
Refuse SweepInput::refusalOf(const std::string& topic) {
  return [this, topic](const std::string& reason) {
    ++statistics_.received;
    statistics_.since_received = WaitingTime();
    refuse(topic, toString(ScanError::kBadStamp), reason);
  };
}

std::string SweepInput::topics() const {
  std::string names;
  for (const ros::Subscriber& subscriber : subscribers_) {
    names += (names.empty() ? "" : ", ") + subscriber.getTopic();
  }
  return names;
}

unsigned SweepInput::publisherCount() const {
  unsigned count = 0;
  for (const ros::Subscriber& subscriber : subscribers_) count += subscriber.getNumPublishers();
  return count;
}

void SweepInput::onScan(const sensor_msgs::LaserScanConstPtr& message, const std::string& topic) {
  if (!accept(message->header, topic)) return;
  const std::size_t beams = message->ranges.size();
  if (beams > max_beams_) {
    refuse(topic, toString(ScanError::kTooManyBeams),
           "it has " + std::to_string(beams) + " beams, ~max_beams allows " +
               std::to_string(max_beams_));
    return;
  }
  Sweep sweep;
  LaserScan scan = fromMessage(*message);
  scan.stamp = toSeconds(
      message->header.stamp);  // same conversion as for IMU stamps, so that both are comparable
  sweep.times = sweepTimes(scan);
  sweep.data = std::move(scan);
  pass(std::move(sweep), message->header, topic);
}

void SweepInput::onCloud(const sensor_msgs::PointCloud2ConstPtr& message,
                         const std::string& topic) {
  if (!accept(message->header, topic)) return;
  Sweep sweep;
  try {
    PointCloud cloud = toPointCloud(*message);
    sweep.times = sweepTimes(cloud);
    sweep.data = std::move(cloud);
  } catch (const std::invalid_argument& error) {
    refuse(topic, "bad-cloud", error.what());
    return;
  }
  pass(std::move(sweep), message->header, topic);
}

/// The checks that are common to all messages. The projector does the other checks.
bool SweepInput::accept(const std_msgs::Header& header, const std::string& topic) {
  ++statistics_.received;
  statistics_.since_received = WaitingTime();
  constexpr std::size_t kMostFrames = 32;  // more are garbage
  if (last_stamps_.size() >= kMostFrames) last_stamps_.clear();
  ros::Time& last_stamp = last_stamps_[topic + " " + withoutSlash(header.frame_id)];
  if (withoutSlash(header.frame_id).empty()) {
    refuse(topic, "no-frame", "its frame_id is empty; the laser driver must set it");
  } else if (header.stamp.isZero()) {
    refuse(topic, toString(ScanError::kBadStamp),
           "its stamp is zero; the laser driver must set it");
  } else if (header.stamp == last_stamp) {
    refuse(topic, "repeated-stamp", "its stamp equals that of the previous scan (two publishers?)");
  } else {
    last_stamp = header.stamp;
    return true;
  }
  return false;
}

void SweepInput::refuse(const std::string& topic, const std::string& reason,
                        const std::string& sentence) {
  statistics_.drop(reason, sentence);
  KESTREL_WARN_THROTTLE(kComplainEvery, "A scan on %s is dropped (%s): %s.", topic.c_str(),
                        reason.c_str(), sentence.c_str());
}

void SweepInput::pass(Sweep sweep, const std_msgs::Header& header, const std::string& topic) {
  sweep.topic = topic;
  sweep.frame = withoutSlash(header.frame_id);
  sweep.stamp = header.stamp;
  on_sweep_(std::move(sweep));
}

}  // namespace kestrel
