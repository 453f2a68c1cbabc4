// SPDX-License-Identifier: BSD-3-Clause
#include "imu_intake.h"

#include <sstream>

namespace kestrel {
namespace {

constexpr double kPeriodShare = 0.02;  // of the newest period in the smoothed one
constexpr double kRounding = 0.01;     // of a period

ImuFault frozenFault(double duration_s) {
  std::ostringstream text;
  text << "the IMU repeats the same reading, bit for bit, for " << duration_s
       << " s; check its driver and cable";
  return {"frozen", text.str()};
}

}  // namespace

ImuIntake::ImuIntake(const PoseFilterConfig& config)
    : config_(config), frozen_(config.imu.frozen_s) {}

std::optional<double> ImuIntake::newest() const { return last_stamp_; }

double ImuIntake::rate() const { return period_s_ > 0.0 ? 1.0 / period_s_ : 0.0; }

ImuIntake::Result ImuIntake::add(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) {
  bad_ = false;
  if (!isUsable(sample, base_T_imu)) {
    bad_ = true;
    return Result::kRejected;
  }
  const StampCheck::Verdict verdict = stamps_.check(sample.stamp);
  if (verdict == StampCheck::Verdict::kLate || verdict == StampCheck::Verdict::kJump) {
    const bool late = verdict == StampCheck::Verdict::kLate;
    fault_ = {late ? "late" : "stamp jumps", late ? "the IMU's samples come out of order"
                                                  : "the IMU's stamps jump; check its clock"};
    return Result::kRejected;
  }
  if (frozen_.add(sample)) {
    fault_ = frozenFault(frozen_.duration());
    bad_ = true;
    return Result::kRejected;
  }
  lever_m_ = base_T_imu.translation();
  const ImuInput reading = inBase(sample, base_T_imu);
  if (verdict == StampCheck::Verdict::kNext) return accumulate(sample.stamp, reading);
  last_stamp_.reset();
  accumulate(sample.stamp, reading);
  return Result::kClockSetBack;
}

bool ImuIntake::isUsable(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) {
  ImuSample raw = sample;
  raw.world_R_imu.reset();  // not used here
  std::optional<ImuFault> fault = faultOfStamp(sample.stamp);
  if (!fault) fault = faultOf(raw);
  if (!fault) fault = faultOf(Eigen::Quaterniond(base_T_imu.linear()), "the IMU's mounting");
  if (!fault && !base_T_imu.translation().allFinite()) {
    fault = ImuFault{"not finite", "the IMU's mounting has a translation that is not finite"};
  }
  if (!fault && !(raw.angular_velocity && raw.linear_acceleration)) {
    fault = ImuFault{"incomplete",
                     "the IMU gives no angular velocity or no acceleration; the filter needs both"};
  }
  if (fault) fault_ = *fault;
  return !fault;
}

ImuInput ImuIntake::inBase(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) const {
  const Eigen::Quaterniond rotation = Eigen::Quaterniond(base_T_imu.linear()).normalized();
  const double rate = sample.angular_velocity->cwiseAbs().maxCoeff();
  const double force = sample.linear_acceleration->cwiseAbs().maxCoeff();
  ImuInput reading;
  reading.rate = rotation * *sample.angular_velocity;
  reading.force = rotation * *sample.linear_acceleration -
                  reading.rate.cross(reading.rate.cross(lever_m_));  // to the base's origin
  reading.rate_saturated = rate >= config_.noise.gyro_range;
  reading.force_saturated = force >= config_.noise.accelerometer_range;
  return reading;
}

ImuIntake::Result ImuIntake::accumulate(double stamp, const ImuInput& reading) {
  if (!last_stamp_) {
    step_ = {stamp, 0.0, reading, reading};
    sum_ = ImuInput();
    last_stamp_ = stamp;
    last_ = reading;
    return Result::kStep;
  }
  const double dt = stamp - *last_stamp_;
  period_s_ = period_s_ > 0.0 ? period_s_ + kPeriodShare * (dt - period_s_) : dt;
  sum_.rate += 0.5 * dt * (last_.rate + reading.rate);
  sum_.force += 0.5 * dt * (last_.force + reading.force);
  // The turn's acceleration times dt; of many steps, noise of the first and the last remains.
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
  sum_ = ImuInput();
  return Result::kStep;
}

}  // namespace kestrel
