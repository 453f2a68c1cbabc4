// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Imu.h>

#include <functional>
#include <optional>
#include <string>

#include "kestrel_slam/pipeline/projection_stage.h"
#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/common/waiting_time.h"

namespace kestrel {

/// Receives IMU messages and passes them to the projection, with the mounting from tf.
class ImuInput {
 public:
  /// `on_attitude` is called with the stamp of every used reading.
  ImuInput(ros::NodeHandle nh, const std::string& topic, const Mountings& mountings,
           ProjectionStage& projection, std::function<void(const ros::Time&)> on_attitude);

  /// Current health of the IMU. The current time is the last IMU stamp plus the time since its
  /// arrival. So a paused replay or stamps of another clock do not cause the state "silent".
  ImuStatus status() const;

  double now() const {
    return last_stamp_ + since_last_.seconds();
  }  ///< on the clock of the IMU stamps, s

  /// Whether a stamp of another sensor (s) is hours away from the stamps of the IMU.
  bool hasOtherClock(double stamp) const;

  /// Message about the missing transform of the IMU; empty if none is missing.
  const std::string& waitingFor() const { return waiting_for_; }

  std::string topic() const { return subscriber_.getTopic(); }
  unsigned publisherCount() const { return subscriber_.getNumPublishers(); }

 private:
  void onImu(const sensor_msgs::ImuConstPtr& message);

  const Mountings& mountings_;
  ImuCheck check_;
  ProjectionStage& projection_;
  std::function<void(const ros::Time&)> on_attitude_;
  std::string waiting_for_;
  std::size_t refused_stamps_ = 0;
  double last_stamp_ = 0.0;  ///< s
  WaitingTime since_last_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
