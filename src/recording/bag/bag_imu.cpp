// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/recording/bag/bag_imu.h"

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "imu_topic.h"
#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/sensor/imu_joiner.h"

namespace kestrel {
namespace {

const std::string kImuType = "sensor_msgs/Imu";

/// The topics of a bag that can be read.
std::vector<ImuTopic> readTopics(const BagFiles& files, const BagTopics& topics,
                                 const BagTransforms& transforms, const std::string& base_frame,
                                 BagImu& result) {
  std::vector<ImuTopic> read;
  for (const auto& [name, topic] : topics) {
    if (topic.type != kImuType || topic.messages == 0) continue;
    try {
      requireVersion<sensor_msgs::Imu>(topics, name);
      read.emplace_back(files, name, transforms, base_frame);
    } catch (const std::runtime_error& error) {
      result.warnings.push_back("the IMU is not used: " + std::string(error.what()));
    }
  }
  return read;
}

void use(const ImuTopic& topic, const BagTransforms& transforms, const std::string& base_frame,
         BagImu& result) {
  result.imu.topic = topic.name();
  result.imu.samples = topic.samples();
  result.broken = topic.broken();
  result.clock_offset = topic.clockOffset();
  if (topic.mounting()) {
    result.imu.base_T_imu = *topic.mounting();
  } else if (!topic.samples().empty()) {
    result.warnings.push_back(
        "the bag has no tf " + base_frame + " -> " +
        (topic.frame().empty() ? "(no frame)" : topic.frame()) +
        ": the IMU axes are assumed to be parallel to those of the vehicle" +
        (transforms.knows(topic.frame()) ? " (tf has the frame, but does not connect it)" : ""));
  }
}

/// The specific force of `accelerometer` in the frame of `gyro`.
void join(const ImuTopic& gyro, const ImuTopic& accelerometer, BagImu& result) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  const Eigen::Matrix3d gyro_R_accelerometer =
      gyro.mounting().value_or(identity).linear().transpose() *
      accelerometer.mounting().value_or(identity).linear();
  ImuJoiner joiner;
  for (const ImuSample& sample : accelerometer.samples()) {
    if (!sample.linear_acceleration) continue;
    joiner.addAccelerometer(sample.stamp, gyro_R_accelerometer * *sample.linear_acceleration);
  }
  for (const ImuSample& sample : gyro.samples()) {
    if (sample.angular_velocity) joiner.addGyro(sample.stamp, *sample.angular_velocity);
  }
  result.imu.samples = joiner.take();
  for (ImuSample& sample : joiner.finish()) result.imu.samples.push_back(std::move(sample));
  result.imu.topic = gyro.name() + " + " + accelerometer.name();
  result.broken += accelerometer.broken();
  result.warnings.push_back("gyro and accelerometer have a topic each; they are joined by stamp: " +
                            gyro.name() + " and " + accelerometer.name());
}

const ImuTopic* most(const std::vector<ImuTopic>& topics, bool (ImuTopic::*has)() const) {
  const ImuTopic* best = nullptr;
  for (const ImuTopic& topic : topics) {
    if (!(topic.*has)()) continue;
    if (best == nullptr || topic.samples().size() > best->samples().size()) best = &topic;
  }
  return best;
}

/// Says what the readings of the chosen topic lack.
void explainGaps(const ImuTopic& topic, BagImu& result) {
  const std::string missing = topic.missing();
  if (missing.empty() || topic.samples().empty()) return;
  result.warnings.push_back("the messages on " + topic.name() + " have " + missing +
                            "; an IMU needs a gyro, and an accelerometer or an orientation");
}

void choose(const std::vector<ImuTopic>& imus, const BagTopics& topics,
            const BagTransforms& transforms, const std::string& base_frame, BagImu& result) {
  const ImuTopic* best = most(imus, &ImuTopic::isComplete);
  const ImuTopic* gyro = most(imus, &ImuTopic::hasGyro);
  const ImuTopic* accelerometer = most(imus, &ImuTopic::hasAccelerometer);
  const bool halves = best == nullptr && gyro != nullptr && accelerometer != nullptr;
  if (best == nullptr) best = gyro;
  if (best == nullptr) best = most(imus, &ImuTopic::hasReadings);
  if (best == nullptr) return;
  use(*best, transforms, base_frame, result);
  if (halves) {
    join(*gyro, *accelerometer, result);
    return;
  }
  explainGaps(*best, result);
  if (imus.size() > 1) {
    result.warnings.push_back(
        "there are several IMU topics; of the complete ones, the one with the most messages is "
        "used: " +
        best->name() + "; topics: " + listTopics(topics, kImuType));
  }
}

}  // namespace

BagImu readBagImu(const BagFiles& files, const BagTopics& topics, const BagTransforms& transforms,
                  const std::string& base_frame, const std::string& wanted) {
  BagImu result;
  if (wanted.empty()) {
    choose(readTopics(files, topics, transforms, base_frame, result), topics, transforms,
           base_frame, result);
    return result;
  }
  const std::string name = requireTopic(topics, wanted, kImuType);
  requireVersion<sensor_msgs::Imu>(topics, name);
  const ImuTopic topic(files, name, transforms, base_frame);
  use(topic, transforms, base_frame, result);
  explainGaps(topic, result);
  return result;
}

}  // namespace kestrel
