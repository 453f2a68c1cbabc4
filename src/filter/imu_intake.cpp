// SPDX-License-Identifier: BSD-3-Clause
#include "imu_intake.h"

#include <sstream>

namespace kestrel {
namespace {

constexpr double kPeriodShare = 0.02;  // weight of the newest period in the smoothed one
constexpr double kRounding = 0.01;     // tolerance, relative to the period

ImuFault frozenFault(double duration_s) {
  std::ostringstream text;
  text << "the IMU has sent the same reading for " << duration_s
       << " s; check its driver and cable";
  return {"frozen", text.str()};
}

}  // namespace

ImuIntake::ImuIntake(const PoseFilterConfig& config) : config_(config) {}

std::optional<double> ImuIntake::newest() const { return last_stamp_; }

double ImuIntake::rate() const { return period_s_ > 0.0 ? 1.0 / period_s_ : 0.0; }

ImuIntake::Result ImuIntake::add(const CheckedImu& reading) {
  const StampCheck::Verdict order = reading.order;
  const std::optional<ImuFault> broken = faultIn(reading);
  bad_ = broken.has_value();
  if (bad_) fault_ = *broken;
  if (bad_) return Result::kRejected;
  if (order == StampCheck::Verdict::kLate || order == StampCheck::Verdict::kJump) {
    const bool late = order == StampCheck::Verdict::kLate;
    fault_ = {late ? "late" : "stamp jumps", late ? "the IMU's samples arrive out of order"
                                                  : "the IMU's stamps jump; check its clock"};
    return Result::kRejected;
  }
  lever_m_ = reading.base_T_imu.translation();
  const InertialInput input = inBase(reading.sample, reading.base_T_imu);
  if (order == StampCheck::Verdict::kNext) return accumulate(reading.sample.stamp, input);
  last_stamp_.reset();
  accumulate(reading.sample.stamp, input);
  return Result::kClockSetBack;
}

/// What makes the reading useless for the filter; the orientation is not used here.
std::optional<ImuFault> ImuIntake::faultIn(const CheckedImu& reading) const {
  if (reading.fault) return reading.fault;
  if (!reading.sample.angular_velocity || !reading.sample.linear_acceleration) {
    return ImuFault{"incomplete",
                    "the IMU gives no angular velocity or no acceleration; the filter needs both"};
  }
  const bool is_in_order =
      reading.order == StampCheck::Verdict::kNext || reading.order == StampCheck::Verdict::kSetBack;
  if (is_in_order && reading.frozen_s >= config_.imu.frozen_s) return frozenFault(reading.frozen_s);
  return std::nullopt;
}

InertialInput ImuIntake::inBase(const ImuSample& sample,
                                const Eigen::Isometry3d& base_T_imu) const {
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(base_T_imu.linear()).normalized();
  const double rate = sample.angular_velocity->cwiseAbs().maxCoeff();
  const double force = sample.linear_acceleration->cwiseAbs().maxCoeff();
  InertialInput reading;
  reading.rate = rotation * *sample.angular_velocity;
  reading.force =
      rotation * *sample.linear_acceleration -
      reading.rate.cross(reading.rate.cross(lever_m_));  // remove the centripetal acceleration
  reading.rate_saturated = rate >= config_.noise.gyro_range;
  reading.force_saturated = force >= config_.noise.accelerometer_range;
  return reading;
}

ImuIntake::Result ImuIntake::accumulate(double stamp, const InertialInput& reading) {
  if (!last_stamp_) {
    step_ = {stamp, 0.0, reading, reading};
    sum_ = InertialInput();
    last_stamp_ = stamp;
    last_ = reading;
    return Result::kStep;
  }
  const double dt = stamp - *last_stamp_;
  period_s_ = period_s_ > 0.0 ? period_s_ + kPeriodShare * (dt - period_s_) : dt;
  sum_.rate += 0.5 * dt * (last_.rate + reading.rate);
  sum_.force += 0.5 * dt * (last_.force + reading.force);
  // Removes the integral of the acceleration due to angular acceleration. Summed over many steps,
  // only noise of the first and the last reading remains.
  sum_.force -= (reading.rate - last_.rate).cross(lever_m_);
  sum_.rate_saturated |= last_.rate_saturated || reading.rate_saturated;
  sum_.force_saturated |= last_.force_saturated || reading.force_saturated;
  last_stamp_ = stamp;
  last_ = reading;
  const double total = stamp - step_.stamp;
  if (total < (1.0 - kRounding) / config_.imu.max_rate_hz) return Result::kMerged;
  step_ = {stamp, total, sum_, reading};
  step_.mean.rate /= total;
  step_.mean.force /= total;
  sum_ = InertialInput();
  return Result::kStep;
}

}  // namespace kestrel
