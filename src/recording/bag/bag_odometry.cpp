// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_odometry.h"

#include <nav_msgs/Odometry.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

const std::string kOdometryType = "nav_msgs/Odometry";

/// True if the name of a topic indicates ground truth, which is not available in flight:
/// /ground_truth, /groundtruth/pose, /gt/odom.
bool namesGroundTruth(const std::string& topic) {
  for (const char* word : {"ground_truth", "groundtruth", "ground-truth"}) {
    if (topic.find(word) != std::string::npos) return true;
  }
  std::istringstream parts(topic);
  for (std::string part; std::getline(parts, part, '/');) {
    if (part == "gt" || part == "truth") return true;
  }
  return false;
}

}  // namespace

BagOdometry::BagOdometry(const BagFiles& files, const std::string& topic) {
  files.forEach(topic, [this](const rosbag::MessageInstance& message) {
    const auto odometry = message.instantiate<nav_msgs::Odometry>();
    if (!odometry) return;  // another type on the same topic
    const Pose2 pose = toPose2(odometry->pose.pose);
    if (!pose.isFinite()) return;
    child_frame_ = withoutSlash(odometry->child_frame_id);
    poses_.push_back({toSeconds(odometry->header.stamp), pose});
  });
  std::stable_sort(poses_.begin(), poses_.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
}

std::optional<Pose2> BagOdometry::at(double stamp) const { return poseAt(poses_, stamp); }

BagOdometrySource::BagOdometrySource(const BagFiles& files, const BagTopics& topics,
                                     const BagTransforms& transforms, std::string base_frame,
                                     const std::string& wanted)
    : transforms_(transforms), base_frame_(std::move(base_frame)) {
  const std::string topic = chooseTopic(topics, wanted);
  if (!topic.empty()) {
    requireVersion<nav_msgs::Odometry>(topics, topic);
    odometry_.emplace(files, topic);
    description_ = "odometry " + topic;
    return;
  }
  for (const std::string& frame : transforms_.ancestors(base_frame_)) {
    if (frame.find("odom") == std::string::npos) continue;
    odom_frame_ = frame;
    description_ = "odometry tf " + odom_frame_ + " -> " + base_frame_;
    return;
  }
}

std::string BagOdometrySource::chooseTopic(const BagTopics& topics, const std::string& wanted) {
  if (!wanted.empty()) {
    std::string topic = requireTopic(topics, wanted, kOdometryType);
    if (namesGroundTruth(topic)) {
      warnings_.push_back("the odometry " + topic + " is ground truth, according to its name: " +
                          "the results are better than in a real flight");
    }
    return topic;
  }
  BagTopics candidates;
  for (const auto& [name, topic] : topics) {
    if (topic.type != kOdometryType) continue;
    if (namesGroundTruth(name)) {
      warnings_.push_back(name +
                          " is ground truth, according to its name, and is not used as odometry");
    } else {
      candidates[name] = topic;
    }
  }
  if (candidates.size() > 1) {
    warnings_.push_back("there are several odometry topics, and none is used; choose one of: " +
                        listTopics(candidates, kOdometryType));
    return "";
  }
  return busiestTopic(candidates, kOdometryType);
}

std::optional<Pose2> BagOdometrySource::at(double stamp, const ros::Time& time) const {
  if (!odometry_) {
    if (odom_frame_.empty()) return std::nullopt;
    const auto odom_T_base = transforms_.lookup(odom_frame_, base_frame_, time);
    return odom_T_base ? std::optional<Pose2>(toPose2(*odom_T_base)) : std::nullopt;
  }
  const std::optional<Pose2> odom_T_child = odometry_->at(stamp);
  const std::string& child = odometry_->childFrame();
  if (!odom_T_child || child.empty() || child == base_frame_) return odom_T_child;
  const auto child_T_base = transforms_.lookup(child, base_frame_, time);
  return child_T_base ? *odom_T_child * toPose2(*child_T_base) : *odom_T_child;
}

}  // namespace kestrel
