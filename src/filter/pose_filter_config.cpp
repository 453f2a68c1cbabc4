// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/filter/pose_filter_config.h"

#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace kestrel {
namespace {

constexpr double kHuge = 1e6;
constexpr double kTiny = 1e-9;  // minimum of values that must be positive

void require(const std::string& name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  std::ostringstream text;
  text << "filter parameter " << name << " is " << value << "; it must be from " << low << " to "
       << high;
  throw std::invalid_argument(text.str());
}

void validateImu(const PoseFilterConfig& c) {
  require("gyro_noise", c.noise.gyro_noise, kTiny, kHuge);
  require("accelerometer_noise", c.noise.accelerometer_noise, kTiny, kHuge);
  require("gyro_bias_walk", c.noise.gyro_bias_walk, 0.0, kHuge);
  require("accelerometer_bias_walk", c.noise.accelerometer_bias_walk, 0.0, kHuge);
  require("gyro_bias_sigma", c.noise.gyro_bias_sigma, kTiny, kHuge);
  require("accelerometer_bias_sigma", c.noise.accelerometer_bias_sigma, kTiny, kHuge);
  require("mounting_sigma_rad", c.noise.mounting_sigma_rad, 0.0, 1.0);
  require("gyro_range", c.noise.gyro_range, kTiny, kHuge);
  require("accelerometer_range", c.noise.accelerometer_range, kTiny, kHuge);
  require("max_rate_hz", c.imu.max_rate_hz, 50.0, 2000.0);
  require("min_rate_hz", c.imu.min_rate_hz, kTiny, c.imu.max_rate_hz);
  require("frozen_s", c.imu.frozen_s, kTiny, kHuge);
  require("silent_s", c.imu.silent_s, kTiny, kHuge);
  require("max_gap_s", c.imu.max_gap_s, c.imu.silent_s, kHuge);
  require("max_gyro_bias", c.max_gyro_bias, kTiny, kHuge);
  require("max_accelerometer_bias", c.max_accelerometer_bias, kTiny, kHuge);
}

void validateMeasurements(const PoseFilterConfig& c) {
  require("probability", c.gate.probability, 0.5, 1.0 - kTiny);
  require("history_s", c.gate.history_s, 0.05, 10.0);
  require("reinitialize_after_s", c.gate.reinitialize_after_s, kTiny, kHuge);
  require("coast_after_s", c.gate.coast_after_s, kTiny, kHuge);
  require("max_reinitializations", c.gate.max_reinitializations, 1.0, kHuge);
  require("diverged_s", c.gate.diverged_s, kTiny, kHuge);
  require("range_sigma_m", c.height.range_sigma_m, kTiny, kHuge);
  require("range_max_m", c.height.range_max_m, kTiny, kHuge);
  require("floor_beam_sigma_m", c.height.floor_beam_sigma_m, kTiny, kHuge);
  require("barometer_sigma_m", c.height.barometer_sigma_m, kTiny, kHuge);
  require("barometer_drift", c.height.barometer_drift, 0.0, kHuge);
  require("initial_sigma_m", c.height.initial_sigma_m, kTiny, kHuge);
  require("step_readings", c.height.step_readings, 1.0, kHuge);
  require("gravity_sigma", c.motion.gravity_sigma, 0.0, kHuge);
  require("gravity_gate", c.motion.gravity_gate, 0.0, 1.0);
  require("gravity_period_s", c.motion.gravity_period_s, kTiny, kHuge);
  require("zero_velocity_sigma", c.motion.zero_velocity_sigma, kTiny, kHuge);
  require("start_speed_sigma", c.motion.start_speed_sigma, kTiny, kHuge);
  require("yaw_sigma_rad", c.yaw_sigma_rad, kTiny, kHuge);
}

}  // namespace

void validate(const PoseFilterConfig& config) {
  validateImu(config);
  validateMeasurements(config);
}

}  // namespace kestrel
