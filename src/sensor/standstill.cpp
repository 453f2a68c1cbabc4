// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/sensor/standstill.h"

#include <cmath>

namespace kestrel {
namespace {

constexpr double kBlock_s = 1.0;
constexpr int kMinReadings = 5;
// Noise of a cheap IMU at rest. Running motors cause more.
constexpr double kRateNoise = 0.02;  // rad/s, all axes together
constexpr double kForceNoise = 0.2;  // m/s²
// A slow rotation about the vertical looks like a bias. Therefore only small values are accepted.
constexpr double kMaxTurn = 0.02;  // rad/s
// About the horizontal axes a rotation would change the direction of gravity, so more is accepted.
constexpr double kMaxRestingRate = 0.1;  // rad/s

}  // namespace

std::optional<Eigen::Vector3d> Standstill::add(double dt, const Eigen::Vector3d& rate,
                                               const Eigen::Vector3d& force) {
  if (count_ == 0) {
    rate_offset_ = rate;
    force_offset_ = force;
  } else {
    time_s_ += dt;
  }
  ++count_;
  const Eigen::Vector3d r = rate - rate_offset_, f = force - force_offset_;
  rate_sum_ += r;
  force_sum_ += f;
  rate_squares_ += r.squaredNorm();
  force_squares_ += f.squaredNorm();
  if (time_s_ < kBlock_s) return std::nullopt;
  const std::optional<Eigen::Vector3d> mean = judge();
  restart();
  return mean;
}

std::optional<Eigen::Vector3d> Standstill::judge() const {
  if (count_ < kMinReadings) return std::nullopt;
  const Eigen::Vector3d rate = rate_sum_ / count_, force = force_sum_ / count_;
  const double rate_variance = rate_squares_ / count_ - rate.squaredNorm();
  const double force_variance = force_squares_ / count_ - force.squaredNorm();
  if (rate_variance > kRateNoise * kRateNoise) return std::nullopt;
  if (force_variance > kForceNoise * kForceNoise) return std::nullopt;
  const Eigen::Vector3d mean = rate + rate_offset_;
  const double turn = mean.dot((force + force_offset_).normalized());
  if (std::abs(turn) > kMaxTurn || mean.norm() > kMaxRestingRate) return std::nullopt;
  return mean;
}

}  // namespace kestrel
