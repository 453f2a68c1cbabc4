// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <Eigen/Core>
#include <deque>
#include <functional>
#include <optional>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/ros/projector/projector_parameters.h"
#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

/// What a pose filter says of the vehicle: its attitude for the projection, and its motion as a
/// prediction for the mapper. States whose covariance says that they are vague are not used.
class FilterInput {
 public:
  /// `on_state` is called with the stamp of every state that was used.
  FilterInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
              std::function<void(const ros::Time&)> on_state);

  /// Whether the filter runs: it has told the attitude of a time not long before `time` (s).
  bool runs(double time) const;
  /// Whether the attitude is known over the whole sweep (kNone), or may be in a moment (kNotYet).
  AttitudeError covers(const SweepTimes& times) const;
  const AttitudeBuffer& buffer() const { return buffer_; }
  /// odom_T_base at `time`, where the filter knows its velocity.
  std::optional<Pose2> predicted(double time) const;

 private:
  struct State {
    double stamp;
    Pose2 odom_T_base;
    Eigen::Vector3d velocity;  ///< in odom, m/s
    bool is_sure;              ///< of its velocity
  };
  void onOdometry(const nav_msgs::OdometryConstPtr& message);
  std::optional<Eigen::Vector3d> specificForce(const State& state,
                                               const Eigen::Quaterniond& odom_R_base) const;

  double history_s_;
  std::function<void(const ros::Time&)> on_state_;
  AttitudeBuffer buffer_;
  std::deque<State> states_;  ///< ascending stamps
  ros::Subscriber subscriber_;
};

}  // namespace kestrel
