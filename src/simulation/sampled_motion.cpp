// SPDX-License-Identifier: BSD-3-Clause
#include "sampled_motion.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

constexpr Eigen::Index kRoll = 3, kPitch = 4, kYaw = 5;

TrueState toState(const SampledMotion::Sample& sample) {
  const auto &angles = sample.position, &rates = sample.velocity;
  TrueState state;
  state.world_T_base.linear() = (Eigen::AngleAxisd(angles[kYaw], Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(angles[kPitch], Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(angles[kRoll], Eigen::Vector3d::UnitX()))
                                    .toRotationMatrix();
  state.world_T_base.translation() = sample.position.head<3>();
  state.velocity = sample.velocity.head<3>();
  state.acceleration = sample.acceleration.head<3>();
  const double sin_roll = std::sin(angles[kRoll]), cos_roll = std::cos(angles[kRoll]);
  const double sin_pitch = std::sin(angles[kPitch]), cos_pitch = std::cos(angles[kPitch]);
  state.angular_velocity = {rates[kRoll] - rates[kYaw] * sin_pitch,
                            rates[kPitch] * cos_roll + rates[kYaw] * sin_roll * cos_pitch,
                            rates[kYaw] * cos_roll * cos_pitch - rates[kPitch] * sin_roll};
  return state;
}

TrueState atRest(const SampledMotion::Sample& sample) {
  SampledMotion::Sample rest;
  rest.position = sample.position;
  return toState(rest);
}

}  // namespace

SampledMotion::Sample SampledMotion::advance(const Sample& from, const Vector6d& acceleration,
                                             double elapsed) {
  Sample to;
  to.acceleration = acceleration;
  to.velocity = from.velocity + (from.acceleration + acceleration) * elapsed / 2.0;
  to.position = from.position + from.velocity * elapsed +
                (2.0 * from.acceleration + acceleration) * elapsed * elapsed / 6.0;
  return to;
}

void SampledMotion::makeLevel() {
  for (Sample& sample : samples_) {
    for (const Eigen::Index angle : {kRoll, kPitch}) {
      sample.position[angle] = sample.velocity[angle] = sample.acceleration[angle] = 0.0;
    }
  }
}

double SampledMotion::duration() const {
  return static_cast<double>(samples_.size() - 1) * step_s_;
}

TrueState SampledMotion::at(double time) const {
  if (!(time > 0.0)) return atRest(samples_.front());
  const double steps = std::floor(time / step_s_);
  const auto last = static_cast<double>(samples_.size() - 1);
  if (steps >= last) return atRest(samples_.back());
  const auto i = static_cast<std::size_t>(steps);
  const Sample &from = samples_[i], &to = samples_[i + 1];
  const double elapsed = std::clamp(time - steps * step_s_, 0.0, step_s_);
  const Vector6d acceleration =
      from.acceleration + (to.acceleration - from.acceleration) * (elapsed / step_s_);
  return toState(advance(from, acceleration, elapsed));
}

}  // namespace kestrel
