// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_reference.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/geometry/pose3.h"
#include "kestrel_slam/messages/conversions.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_files.h"
#include "kestrel_slam/recording/bag/bag_topics.h"

namespace kestrel {
namespace {

const std::vector<std::string> kTypes = {
    "geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped", "nav_msgs/Odometry"};

std::string chooseTopic(const BagTopics& topics, const std::string& wanted) {
  if (!wanted.empty()) return requireTopic(topics, wanted, kTypes);
  std::vector<std::string> candidates;
  for (const auto& [name, topic] : topics) {
    if (std::find(kTypes.begin(), kTypes.end(), topic.type) != kTypes.end()) {
      candidates.push_back(name);
    }
  }
  if (candidates.empty()) {
    throw std::runtime_error("has no topic with poses; its topics: " + listTopics(topics, ""));
  }
  if (candidates.size() > 1) {
    throw std::runtime_error("has several topics with poses; choose one as reference: " +
                             listTopics(topics, kTypes));
  }
  return candidates.front();
}

/// False for a zero quaternion, which motion capture systems send when they lose the body.
bool isRotation(const geometry_msgs::Quaternion& q) {
  constexpr double kMinNorm = 0.5;
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w) > kMinNorm;
}

std::optional<StampedPose> stampedPose(const std_msgs::Header& header,
                                       const geometry_msgs::Pose& pose) {
  const Pose2 value = toPose2(pose);
  if (header.stamp.isZero() || !value.isFinite() || !isRotation(pose.orientation)) {
    return std::nullopt;
  }
  return StampedPose{toSeconds(header.stamp), value};
}

std::optional<StampedPose> poseOf(const rosbag::MessageInstance& instance) {
  if (const auto pose = instance.instantiate<geometry_msgs::PoseStamped>()) {
    return stampedPose(pose->header, pose->pose);
  }
  if (const auto pose = instance.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
    return stampedPose(pose->header, pose->pose.pose);
  }
  if (const auto odometry = instance.instantiate<nav_msgs::Odometry>()) {
    return stampedPose(odometry->header, odometry->pose.pose);
  }
  return std::nullopt;
}

Trajectory readTopic(const BagFiles& files, const std::string& topic) {
  Trajectory trajectory;
  files.forEach(topic, [&](const rosbag::MessageInstance& instance) {
    if (const auto pose = poseOf(instance)) trajectory.push_back(*pose);
  });
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; });
  const auto same = [](const StampedPose& a, const StampedPose& b) { return a.stamp == b.stamp; };
  trajectory.erase(std::unique(trajectory.begin(), trajectory.end(), same), trajectory.end());
  return trajectory;
}

}  // namespace

Trajectory readBagReference(const std::string& path, const std::string& topic) {
  const BagFiles files({path});
  try {
    const std::string chosen = chooseTopic(files.topics(), topic);
    Trajectory trajectory = readTopic(files, chosen);
    if (trajectory.empty()) {
      throw std::runtime_error("topic " + chosen + " has no usable pose with a stamp");
    }
    return trajectory;
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace kestrel
