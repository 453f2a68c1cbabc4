// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/filtered_motion.h"

#include <algorithm>

namespace kestrel {
namespace {

/// A filter without a new state for this time is considered stopped, s.
constexpr double kSilent = 0.2;

}  // namespace

FilteredMotion motionOf(const FilterOutput& output) {
  FilteredMotion motion;
  motion.stamp = output.stamp;
  motion.odom_R_base = Eigen::Quaterniond(output.odom_T_base.linear());
  motion.angular_velocity = output.angular_velocity;
  motion.specific_force = output.specific_force;
  motion.odom_T_base = output.odomPose();
  motion.velocity = Eigen::Rotation2Dd(-output.yaw()) * output.velocity.head<2>();
  if (output.givesHeight()) motion.height_m = output.height();
  motion.gives_attitude = output.givesAttitude();
  motion.gives_prediction = output.givesPrediction();
  return motion;
}

FilteredMotionBuffer::FilteredMotionBuffer(const AttitudeBufferConfig& config)
    : history_s_(config.history_s), attitude_(config) {}

bool FilteredMotionBuffer::add(const FilteredMotion& motion) {
  if (!states_.empty() && motion.stamp < states_.back().stamp) {
    states_.clear();
    attitude_.clear();
  }
  const bool is_used =
      motion.gives_attitude && attitude_.add(motion.stamp, motion.odom_R_base,
                                             motion.angular_velocity, motion.specific_force);
  if (motion.gives_attitude && !is_used) return false;
  const bool is_newest = states_.empty() || motion.stamp > states_.back().stamp;
  if (is_newest) {
    states_.push_back({motion.stamp, motion.odom_T_base,
                       motion.gives_prediction && motion.odom_T_base.isFinite()});
  }
  while (states_.front().stamp < states_.back().stamp - history_s_) states_.pop_front();
  return is_used;
}

bool FilteredMotionBuffer::runs(double time) const {
  const std::optional<double> latest = attitude_.latest();
  return latest && *latest > time - kSilent && *latest < time + history_s_;
}

std::optional<Pose2> FilteredMotionBuffer::odomPose(double time) const {
  const auto after = std::lower_bound(states_.begin(), states_.end(), time,
                                      [](const State& state, double t) { return state.stamp < t; });
  if (after == states_.end() || !after->gives_prediction) return std::nullopt;
  if (after->stamp == time) return after->odom_T_base;
  if (after == states_.begin() || !(after - 1)->gives_prediction) return std::nullopt;
  const State &a = *(after - 1), &b = *after;
  const double span = b.stamp - a.stamp;
  if (span > kSilent) return std::nullopt;
  return interpolate(a.odom_T_base, b.odom_T_base, (time - a.stamp) / span);
}

}  // namespace kestrel
