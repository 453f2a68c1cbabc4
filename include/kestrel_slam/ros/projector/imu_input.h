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

/// Receives the IMU and gives its readings, with the mounting by tf, to the projection.
class ImuInput {
 public:
  /// `on_attitude` is called with the stamp of every reading that was used.
  ImuInput(ros::NodeHandle nh, const std::string& topic, const Mountings& mountings,
           ProjectionStage& projection, std::function<void(const ros::Time&)> on_attitude);

  /// Health of the IMU now. Time is that of its stamps, carried on since its last message, so that
  /// neither a paused replay nor stamps of another clock make it silent.
  ImuStatus status() const;

  double now() const { return last_stamp_ + since_last_.seconds(); }  ///< by the IMU's stamps, s

  /// A sentence about the transform that its readings wait for; empty where they do not.
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
  double last_stamp_ = 0.0;  ///< s
  WaitingTime since_last_;
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
