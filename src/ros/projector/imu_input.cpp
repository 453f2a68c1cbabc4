// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/imu_input.h"

#include <ros/console.h>

#include <cmath>
#include <utility>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/ros/common/guarded.h"
#include "kestrel_slam/ros/common/wall_throttle.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 200;   // half a second of data of a fast IMU
constexpr double kComplainEvery = 5.0;  // s
constexpr char kRefusedStamp[] = "implausible-stamp";

}  // namespace

ImuInput::ImuInput(ros::NodeHandle nh, const std::string& topic, const Mountings& mountings,
                   ProjectionStage& projection, std::function<void(const ros::Time&)> on_attitude)
    : mountings_(mountings), projection_(projection), on_attitude_(std::move(on_attitude)) {
  subscriber_ = subscribeGuarded<sensor_msgs::Imu>(
      nh, topic, kQueue, [this](const sensor_msgs::ImuConstPtr& message) { onImu(message); },
      [this](const std::string& reason) {
        ++refused_stamps_;
        logRefusal(this->topic(), reason);
      });
}

void ImuInput::onImu(const sensor_msgs::ImuConstPtr& message) {
  const std::string frame = withoutSlash(message->header.frame_id);
  const std::optional<Eigen::Isometry3d> base_T_imu = mountings_.lookup(frame);
  if (!base_T_imu) {
    waiting_for_ = mountings_.missing("IMU", frame);
    KESTREL_WARN_THROTTLE(kComplainEvery, "Messages on %s are not used: %s", topic().c_str(),
                          waiting_for_.c_str());
    return;
  }
  waiting_for_.clear();
  const ImuSample sample = toImuSample(*message);
  last_stamp_ = sample.stamp;
  since_last_ = WaitingTime();
  if (projection_.gyroInDegrees()) check_.convertGyro();
  if (projection_.addImu(check_.check(sample, *base_T_imu))) {
    on_attitude_(message->header.stamp);
  }
}

bool ImuInput::hasOtherClock(double stamp) const {
  constexpr double kOtherClock = 3600.0;  // s; late messages are late by seconds
  return last_stamp_ > 0.0 && std::abs(stamp - now()) > kOtherClock;
}

ImuStatus ImuInput::status() const {
  ImuStatus status = projection_.tracker().status(now());
  if (refused_stamps_ > 0) status.rejected[kRefusedStamp] += refused_stamps_;
  return status;
}

}  // namespace kestrel
