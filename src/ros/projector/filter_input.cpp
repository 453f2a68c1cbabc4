// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/projector/filter_input.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "kestrel_slam/geometry/gravity.h"
#include "kestrel_slam/geometry/pose3.h"

namespace kestrel {
namespace {

constexpr std::uint32_t kQueue = 400;
constexpr double kComplainEvery = 5.0;  // s
/// A filter that has said nothing for this long does not run, s.
constexpr double kSilent = 0.2;
/// Vaguer states are of no use (FilterOutput::givesAttitude, givesPrediction).
constexpr double kUsefulTilt = 0.01, kUsefulSpeed = 0.2;  // rad, m/s

// Places in the covariances of ROS (x, y, z, roll, pitch, yaw).
constexpr std::size_t kX = 0, kY = 7, kRoll = 21, kPitch = 28;

bool areKnown(double variance_a, double variance_b, double limit) {
  return variance_a >= 0.0 && variance_b >= 0.0 && std::max(variance_a, variance_b) < limit * limit;
}

}  // namespace

FilterInput::FilterInput(ros::NodeHandle nh, const ProjectorNodeConfig& config,
                         std::function<void(const ros::Time&)> on_state)
    : history_s_(config.slam.attitude.buffer.history_s),
      on_state_(std::move(on_state)),
      buffer_(config.slam.attitude.buffer) {
  if (config.filter_topic.empty() || !config.usesImu()) return;
  subscriber_ = nh.subscribe(config.filter_topic, kQueue, &FilterInput::onOdometry, this,
                             ros::TransportHints().tcpNoDelay());
}

void FilterInput::onOdometry(const nav_msgs::OdometryConstPtr& message) {
  const auto& pose = message->pose.pose;
  const auto& twist = message->twist.twist;
  const Eigen::Quaterniond orientation(pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                       pose.orientation.z);
  const Eigen::Vector3d rate(twist.angular.x, twist.angular.y, twist.angular.z);
  const Eigen::Vector3d velocity(twist.linear.x, twist.linear.y, twist.linear.z);
  State state{message->header.stamp.toSec(), {}, orientation * velocity, false};
  if (!states_.empty() && state.stamp < states_.back().stamp - history_s_) {  // a clock set back
    states_.clear();
    buffer_.clear();
  }
  const auto& known = message->pose.covariance;
  if (!areKnown(known[kRoll], known[kPitch], kUsefulTilt)) return;
  if (!buffer_.add(state.stamp, orientation, rate, specificForce(state, orientation))) {
    ROS_WARN_THROTTLE(kComplainEvery, "A state on %s is not used: not finite, or twice.",
                      subscriber_.getTopic().c_str());
    return;
  }
  state.odom_T_base = Pose2(pose.position.x, pose.position.y, yawOf(orientation));
  state.is_sure =
      state.odom_T_base.isFinite() && state.velocity.allFinite() &&
      areKnown(message->twist.covariance[kX], message->twist.covariance[kY], kUsefulSpeed);
  if (states_.empty() || state.stamp > states_.back().stamp) states_.push_back(state);
  while (states_.front().stamp < states_.back().stamp - history_s_) states_.pop_front();
  on_state_(message->header.stamp);
}

/// What an accelerometer would have felt since the state before; the filter's own has no message.
std::optional<Eigen::Vector3d> FilterInput::specificForce(
    const State& state, const Eigen::Quaterniond& odom_R_base) const {
  if (states_.empty()) return std::nullopt;
  const double seconds = state.stamp - states_.back().stamp;
  if (!(seconds > 0.0) || seconds > kSilent) return std::nullopt;
  const Eigen::Vector3d acceleration = (state.velocity - states_.back().velocity) / seconds;
  return odom_R_base.conjugate() * (acceleration + kGravity * Eigen::Vector3d::UnitZ());
}

bool FilterInput::runs(double time) const {
  const std::optional<double> latest = buffer_.latest();
  return latest && *latest > time - kSilent;
}

AttitudeError FilterInput::covers(const SweepTimes& times) const {
  return buffer_.covers(times.first, times.last);
}

std::optional<Pose2> FilterInput::predicted(double time) const {
  const auto after = std::lower_bound(states_.begin(), states_.end(), time,
                                      [](const State& state, double t) { return state.stamp < t; });
  if (after == states_.end() || !after->is_sure) return std::nullopt;
  if (after->stamp == time) return after->odom_T_base;
  if (after == states_.begin() || !(after - 1)->is_sure) return std::nullopt;
  const State &a = *(after - 1), &b = *after;
  const double span = b.stamp - a.stamp;
  if (span > kSilent) return std::nullopt;
  const double share = (time - a.stamp) / span;
  const Pose2 &from = a.odom_T_base, &to = b.odom_T_base;
  return Pose2(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y),
               from.yaw + share * normalizeAngle(to.yaw - from.yaw));
}

}  // namespace kestrel
