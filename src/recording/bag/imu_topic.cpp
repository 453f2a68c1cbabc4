// SPDX-License-Identifier: BSD-3-Clause
#include "imu_topic.h"

#include <stdexcept>
#include <utility>

#include "kestrel_slam/messages/sensor_messages.h"

namespace kestrel {
namespace {

bool isFilled(const geometry_msgs::Vector3& v) { return v.x != 0.0 || v.y != 0.0 || v.z != 0.0; }

bool isFilled(const geometry_msgs::Quaternion& q) {
  return q.x != 0.0 || q.y != 0.0 || q.z != 0.0 || q.w != 0.0;
}

}  // namespace

ImuTopic::ImuTopic(const BagFiles& files, std::string name, const BagTransforms& transforms,
                   const std::string& base_frame)
    : name_(std::move(name)) {
  broken_ = files.forEach(name_, [&](const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<sensor_msgs::Imu>();
    if (message) add(*message, instance, transforms, base_frame);
  });
}

void ImuTopic::add(sensor_msgs::Imu& message, const rosbag::MessageInstance& instance,
                   const BagTransforms& transforms, const std::string& base_frame) {
  if (message.header.stamp.isZero()) message.header.stamp = instance.getTime();
  if (!base_T_imu_) {
    frame_ = withoutSlash(message.header.frame_id);
    // Without this check, the lookup would fail at every message.
    if (transforms.connected(base_frame, frame_)) {
      base_T_imu_ = transforms.lookup(base_frame, frame_, message.header.stamp);
    }
  }
  ImuSample sample = toImuSample(message);
  if (samples_.empty()) clock_offset_ = sample.stamp - toSeconds(instance.getTime());
  const auto note = [](Value& value, bool given, bool filled) {
    (given ? value.given : value.marked) = true;
    value.filled = value.filled || filled;
  };
  note(orientation_, sample.world_R_imu.has_value(), isFilled(message.orientation));
  note(gyro_, sample.angular_velocity.has_value(), isFilled(message.angular_velocity));
  note(accelerometer_, sample.linear_acceleration.has_value(),
       isFilled(message.linear_acceleration));
  samples_.push_back(std::move(sample));
}

std::string ImuTopic::missing() const {
  if (isComplete()) return "";
  std::string marked, zero;
  for (const auto& [value, what] : {std::pair{&orientation_, "orientation"},
                                    {&gyro_, "gyro"},
                                    {&accelerometer_, "accelerometer"}}) {
    if (value->exists()) continue;
    std::string& list = value->given ? zero : marked;
    list += (list.empty() ? "" : ", ") + std::string(what);
  }
  const bool filled =
      (gyro_.filled && !gyro_.given) || (accelerometer_.filled && !accelerometer_.given);
  std::string text;
  if (!marked.empty()) {
    text = "no " + marked + " (covariance[0] is -1" +
           (filled ? ", although there are values: correct the driver)" : ")");
  }
  if (!zero.empty()) text += (text.empty() ? "no " : " and no ") + zero + " (always 0)";
  return text;
}

}  // namespace kestrel
