// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/imu_input.h"

#include <ros/console.h>

#include <utility>

#include "kestrel_slam/messages/sensor_messages.h"
#include "kestrel_slam/recording/bag/bag_imu.h"
#include "kestrel_slam/recording/bag/bag_transforms.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 200;   // half a second of a fast IMU
constexpr double kComplainEvery = 5.0;  // s

}  // namespace

ImuInput::ImuInput(ros::NodeHandle nh, const std::string& topic, const Mountings& mountings,
                   AttitudeTracker& tracker, std::function<void(const ros::Time&)> on_attitude)
    : mountings_(mountings), tracker_(tracker), on_attitude_(std::move(on_attitude)) {
  subscriber_ =
      nh.subscribe(topic, kQueue, &ImuInput::onImu, this, ros::TransportHints().tcpNoDelay());
}

void ImuInput::onImu(const sensor_msgs::ImuConstPtr& message) {
  const std::string frame = withoutSlash(message->header.frame_id);
  const std::optional<Eigen::Isometry3d> base_T_imu = mountings_.lookup(frame);
  if (!base_T_imu) {
    waiting_for_ = mountings_.missing("IMU", frame);
    ROS_WARN_THROTTLE(kComplainEvery, "Messages on %s are not used: %s", topic().c_str(),
                      waiting_for_.c_str());
    return;
  }
  waiting_for_.clear();
  const ImuSample sample = toImuSample(*message);
  last_stamp_ = sample.stamp;
  since_last_ = WaitingTime();
  if (tracker_.add(sample, Eigen::Quaterniond(base_T_imu->linear()))) {
    on_attitude_(message->header.stamp);
  }
}

ImuStatus ImuInput::status() const { return tracker_.status(last_stamp_ + since_last_.seconds()); }

}  // namespace kestrel
