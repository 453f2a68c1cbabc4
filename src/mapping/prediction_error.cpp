// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/mapping/prediction_error.h"

#include <algorithm>
#include <cmath>

namespace kestrel {
namespace {

/// Standard deviation of the velocity at the last match, m/s, and its growth, m/s². A quadrotor
/// that is tilted by 9 degrees accelerates with 1.5 m/s². With an accelerometer the error is that
/// of the attitude: half a degree.
constexpr double kFirstSpeedError = 0.15, kFirstMeasuredSpeed = 0.05;
constexpr double kAccelerationError = 1.5, kMeasuredAccelerationError = 0.1;
constexpr double kFastest = 3.0;  // m/s

/// The same for the yaw, rad/s and rad/s².
constexpr double kFirstRate = 0.1, kUnknownAngularAcceleration = 3.0, kMaxRate = 4.0;
constexpr double kGyroError = 0.01;  // rad/s
/// Standard deviation of a yaw of which nothing is known: uniform in ±180 degrees.
constexpr double kUnknownYaw = 1.82;

/// Extends `total` by a step in which its rate grows to at most `max_rate`.
void extend(double seconds, double growth, double max_rate, double& rate, double& total) {
  const double before = rate;
  rate = std::max(before, std::min(before + seconds * growth, max_rate));
  total += seconds * 0.5 * (before + rate);
}

}  // namespace

void PredictionError::grow(const PredictedStep& step) {
  growYaw(step);
  const double moved = step.motion.distance();
  if (step.source == PredictionSource::kOdometry) {
    position_m_ += step.odometry.position_m + yaw_rad_ * moved;
    return;
  }
  const bool measured = step.source == PredictionSource::kAccelerometer;
  speed_m_s_ = std::max(speed_m_s_, measured ? kFirstMeasuredSpeed : kFirstSpeedError);
  extend(step.seconds, measured ? kMeasuredAccelerationError : kAccelerationError, kFastest,
         speed_m_s_, position_m_);
}

void PredictionError::growYaw(const PredictedStep& step) {
  if (!step.yaw_measured) {
    rate_rad_s_ = std::max(rate_rad_s_, kFirstRate);
    extend(step.seconds, kUnknownAngularAcceleration, kMaxRate, rate_rad_s_, yaw_rad_);
  } else if (step.source == PredictionSource::kOdometry) {
    yaw_rad_ += step.odometry.yaw_rad;
  } else {
    yaw_rad_ += kGyroError * step.seconds;
  }
  yaw_rad_ = std::min(yaw_rad_, kUnknownYaw);
}

}  // namespace kestrel
