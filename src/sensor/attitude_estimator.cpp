// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/attitude_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/geometry/gravity.h"

namespace kestrel {
namespace {

constexpr double kStart_s = 0.25;  // the first attitude is the mean over this time
constexpr std::size_t kMinStartReadings = 3;
constexpr double kStartGate = 0.4;  // allowed relative difference between that mean and gravity

constexpr double kMaxStep_s = 0.5;  // the gyro is not integrated over longer gaps
constexpr double kSmooth_s = 0.1;  // smoothing time of the specific force; removes motor vibrations
// Rad/s; above, an IMU off the rotation axis measures centripetal acceleration.
constexpr double kModerateRate = 3.0;

// The first corrections are fast, as if averaging all readings since the initialization.
constexpr double kFastestCorrection_s = 0.5;
// An acceleration of 2 m/s² for 2 s causes a tilt error of kErrorLimit * (exp(2 / kLimitGrowth_s) -
// 1) * kLimitGrowth_s / gravity_time: 1.1 degrees with a gravity_time of 4 s.
const double kErrorLimit = degToRad(1.5);
constexpr double kLimitGrowth_s = 3.0;  // the limit grows by a factor e in this time
constexpr double kLimitRelease = 2.0;   // the limit shrinks this many times faster than it grows
constexpr double kMaxGrowth = 120.0;    // allows 180 degrees

// Time constant of the first bias estimates, in units of gravity_time.
constexpr double kFastestBias = 4.0;
constexpr double kMaxBias = 0.2;  // rad/s; more is a rotation or a broken gyro
// Smallest gain with which the mean of a standstill changes the bias.
constexpr double kStandstillGain = 0.3;

/// Rotation vector in `world` that aligns `up` with the z axis of `world`, rad.
Eigen::Vector3d rotationToVertical(const Eigen::Vector3d& up) {
  const double sine = std::hypot(up.x(), up.y());
  const double angle = std::atan2(sine, up.z());
  if (sine <= std::numeric_limits<double>::min())
    return {angle, 0.0, 0.0};  // any horizontal axis is right
  return Eigen::Vector3d(up.y(), -up.x(), 0.0) * (angle / sine);
}

double blend(double dt, double time_s) { return 1.0 - std::exp(-dt / time_s); }

}  // namespace

Eigen::Quaterniond rotationBy(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle <= std::numeric_limits<double>::min()) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Eigen::Quaterniond leveled(const Eigen::Vector3d& up) { return rotationBy(rotationToVertical(up)); }

AttitudeEstimator::AttitudeEstimator(const AttitudeConfig& config) : config_(config) {}

void AttitudeEstimator::restart() {
  const AttitudeConfig config = config_;
  const Eigen::Vector3d bias = bias_;
  *this = AttitudeEstimator(config);
  bias_ = bias;
}

const std::vector<EstimatedAttitude>& AttitudeEstimator::add(double stamp,
                                                             const Eigen::Vector3d& rate,
                                                             const Eigen::Vector3d& force) {
  known_.clear();
  const Reading reading{stamp, rate, force};
  const double dt = last_ ? stamp - last_->stamp : 0.0;
  if (last_ && dt <= 0.0) return known_;
  if (!last_ || dt > kMaxStep_s) {
    beginAt(reading);
  } else {
    step(reading, dt);
  }
  last_ = reading;
  return known_;
}

void AttitudeEstimator::beginAt(const Reading& reading) {
  started_ = false;
  first_.clear();
  first_force_.setZero();
  world_R_base_.setIdentity();
  standstill_.restart();
  collect(reading);
}

void AttitudeEstimator::step(const Reading& reading, double dt) {
  integrate(reading, dt);
  learnStandstill(reading, dt);
  if (!started_) {
    collect(reading);
    return;
  }
  if (dt > config_.buffer.max_gap_s) settled_s_ = 0.0;  // the attitude is uncertain after a gap
  force_ += blend(dt, kSmooth_s) * (world_R_base_ * reading.force - force_);
  correct(reading.rate - bias_, dt);
  if (!world_R_base_.coeffs().allFinite() || !force_.allFinite()) {
    beginAt(reading);
    return;
  }
  emit(reading);
}

void AttitudeEstimator::integrate(const Reading& reading, double dt) {
  const Eigen::Vector3d before = last_->rate - bias_, now = reading.rate - bias_;
  // The second term corrects for a rotation axis that changes (coning; Magnus expansion).
  constexpr double kConing = 1.0 / 12.0;
  const Eigen::Vector3d turn = 0.5 * dt * (before + now) + kConing * dt * dt * before.cross(now);
  world_R_base_ = (world_R_base_ * rotationBy(turn)).normalized();
}

void AttitudeEstimator::collect(const Reading& reading) {
  first_.push_back({reading.stamp, world_R_base_, reading.rate - bias_});
  first_force_ += world_R_base_ * reading.force;
  const double duration = reading.stamp - first_.front().stamp;
  if (first_.size() >= kMinStartReadings && duration >= kStart_s) start(reading);
}

void AttitudeEstimator::start(const Reading& reading) {
  const Eigen::Vector3d mean = first_force_ / static_cast<double>(first_.size());
  const double norm = mean.norm();
  if (!(std::abs(norm - kGravity) <= kStartGate * kGravity)) {
    refused_gravity_ = norm;
    beginAt(reading);
    return;
  }
  const Eigen::Quaterniond world_R_first = leveled(mean);
  world_R_base_ = (world_R_first * world_R_base_).normalized();
  force_ = world_R_first * mean;
  for (EstimatedAttitude& attitude : first_) {
    attitude.world_R_base = (world_R_first * attitude.world_R_base).normalized();
  }
  known_.swap(first_);
  started_ = true;
  refused_gravity_.reset();
  settled_s_ = kStart_s;
  limited_s_ = 0.0;
}

void AttitudeEstimator::emit(const Reading& reading) {
  known_.push_back({reading.stamp, world_R_base_, reading.rate - bias_});
}

void AttitudeEstimator::correct(const Eigen::Vector3d& rate, double dt) {
  const bool is_gravity = std::abs(force_.norm() - kGravity) <= config_.gravity_gate * kGravity;
  if (!is_gravity || rate.norm() > kModerateRate) return;
  settled_s_ += dt;
  const double time_s =
      std::min(config_.gravity_time_s, std::max(kFastestCorrection_s, settled_s_));
  const Eigen::Vector3d error = limited(rotationToVertical(force_), time_s, dt);
  const Eigen::Quaterniond correction = rotationBy(blend(dt, time_s) * error);
  world_R_base_ = (correction * world_R_base_).normalized();
  force_ = correction * force_;
  if (settled_s_ < config_.gravity_time_s)
    return;  // the error is still that of the initialization, not of the gyro
  // The bias estimate must be slower than the attitude correction, or the two oscillate.
  const double bias_time_s =
      std::min(config_.bias_time_s, std::max(kFastestBias * config_.gravity_time_s, settled_s_));
  const double gain = std::min(dt / (config_.gravity_time_s * bias_time_s), 1.0);
  bias_ -= gain * (world_R_base_.conjugate() * error);
  bias_ = bias_.cwiseMax(-kMaxBias).cwiseMin(kMaxBias);
}

Eigen::Vector3d AttitudeEstimator::limited(const Eigen::Vector3d& error, double time_s, double dt) {
  const double growth = std::min(std::exp(limited_s_ / kLimitGrowth_s), kMaxGrowth);
  const double limit = kErrorLimit * growth * config_.gravity_time_s / time_s;
  const double size = error.norm();
  if (limited_s_ <= 0.0) limited_direction_ = error;
  if (size > kErrorLimit && limited_direction_.dot(error) > 0.0) {
    limited_s_ = std::min(limited_s_ + dt, kLimitGrowth_s * std::log(kMaxGrowth));
  } else {
    limited_s_ = std::max(limited_s_ - kLimitRelease * dt, 0.0);
  }
  return size > limit ? Eigen::Vector3d(error * (limit / size)) : error;
}

void AttitudeEstimator::learnStandstill(const Reading& reading, double dt) {
  const std::optional<Eigen::Vector3d> mean = standstill_.add(dt, reading.rate, reading.force);
  if (!mean) return;
  ++standstills_;
  bias_ += std::max(kStandstillGain, 1.0 / standstills_) * (*mean - bias_);
  settled_s_ = std::max(settled_s_, config_.gravity_time_s);
}

}  // namespace kestrel
