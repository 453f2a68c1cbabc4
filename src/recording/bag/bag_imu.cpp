// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_imu.h"

#include <rosbag/view.h>

#include <optional>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_odometry.h"

namespace kestrel {
namespace {

const std::string kImuType = "sensor_msgs/Imu";

std::string chooseTopic(const BagTopics& topics, const std::string& wanted, BagImu& result) {
  if (!wanted.empty()) {
    const std::string topic = requireTopic(topics, wanted, kImuType);
    requireVersion<sensor_msgs::Imu>(topics, topic);
    return topic;
  }
  std::string topic = busiestTopic(topics, kImuType);
  if (topic.empty()) return topic;
  try {
    requireVersion<sensor_msgs::Imu>(topics, topic);
  } catch (const std::runtime_error& error) {
    result.warnings.push_back("the IMU is not used: " + std::string(error.what()));
    return "";
  }
  if (countOfType(topics, kImuType) > 1) {
    result.warnings.push_back(
        "there are several IMU topics; the one with the most messages is used: " + topic +
        "; topics: " + listTopics(topics, kImuType));
  }
  return topic;
}

/// Finds the mounting at the first message for which tf has a transform.
class MountingFinder {
 public:
  MountingFinder(const BagTransforms& transforms, std::string base_frame)
      : transforms_(transforms), base_frame_(std::move(base_frame)) {}

  void look(const sensor_msgs::Imu& message) {
    if (base_T_imu_) return;
    frame_ = withoutSlash(message.header.frame_id);
    if (!transforms_.connected(base_frame_, frame_)) return;  // the lookup would fail at any time
    base_T_imu_ = transforms_.lookup(base_frame_, frame_, message.header.stamp);
  }

  void finish(BagImu& result) const {
    if (base_T_imu_) {
      result.imu.base_T_imu = *base_T_imu_;
    } else if (!result.imu.samples.empty()) {
      result.warnings.push_back(
          "the bag has no tf " + base_frame_ + " -> " + (frame_.empty() ? "(no frame)" : frame_) +
          ": the IMU axes are assumed to be parallel to those of the vehicle");
    }
  }

 private:
  const BagTransforms& transforms_;
  std::string base_frame_, frame_;
  std::optional<Eigen::Isometry3d> base_T_imu_;
};

}  // namespace

BagImu readBagImu(const rosbag::Bag& bag, const BagTopics& topics, const BagTransforms& transforms,
                  const std::string& base_frame, const std::string& wanted) {
  BagImu result;
  const std::string topic = chooseTopic(topics, wanted, result);
  if (topic.empty()) return result;
  result.imu.topic = topic;
  MountingFinder mounting(transforms, base_frame);
  rosbag::View view(bag, rosbag::TopicQuery(topic));
  for (const rosbag::MessageInstance& instance : view) {
    try {
      const auto message = instance.instantiate<sensor_msgs::Imu>();
      if (!message) continue;  // another type on the same topic
      if (message->header.stamp.isZero()) message->header.stamp = instance.getTime();
      mounting.look(*message);
      result.imu.samples.push_back(toImuSample(*message));
    } catch (const std::exception&) {
      ++result.broken;
    }
  }
  mounting.finish(result);
  return result;
}

}  // namespace kestrel
