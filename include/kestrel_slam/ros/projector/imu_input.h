// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Imu.h>

#include <functional>
#include <optional>
#include <string>

#include "kestrel_slam/ros/common/mountings.h"
#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/sensor/attitude_tracker.h"

namespace kestrel {

/// Receives the IMU and feeds its readings, with the mounting by tf, to an attitude tracker.
class ImuInput {
 public:
  /// `on_attitude` is called with the stamp of every reading that was used.
  ImuInput(ros::NodeHandle nh, const std::string& topic, const Mountings& mountings,
           AttitudeTracker& tracker, std::function<void(const ros::Time&)> on_attitude);

  /// Health of the IMU now. Time is that of its stamps, carried on since its last message, so that
  /// neither a paused replay nor stamps of another clock make it silent.
  ImuStatus status() const;

  /// A sentence about the transform that its readings wait for; empty where they do not.
  const std::string& waitingFor() const { return waiting_for_; }

  std::string topic() const { return subscriber_.getTopic(); }
  unsigned publisherCount() const { return subscriber_.getNumPublishers(); }

 private:
  void onImu(const sensor_msgs::ImuConstPtr& message);

  const Mountings& mountings_;
  AttitudeTracker& tracker_;
  std::function<void(const ros::Time&)> on_attitude_;
  std::string waiting_for_;
  double last_stamp_ = 0.0;  ///< s
  WaitingTime since_last_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
