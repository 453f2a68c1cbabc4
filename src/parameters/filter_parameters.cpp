// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/filter_parameters.h"

#include <iterator>

#include "kestrel_slam/parameters/parameter_table.h"

namespace kestrel {
namespace {

using namespace parameter_table;

constexpr double kTiny = 1e-9, kHuge = 1e6;

std::vector<Parameter> imuParametersOf(PoseFilterConfig& filter) {
  ImuNoiseConfig& noise = filter.noise;
  ImuInputConfig& imu = filter.imu;
  return {
      number("gyro_noise", "rad/s/sqrt(Hz)", &noise.gyro_noise, kTiny, kHuge,
             "density of the gyro's noise"),
      number("accelerometer_noise", "m/s²/sqrt(Hz)", &noise.accelerometer_noise, kTiny, kHuge,
             "density of the accelerometer's noise"),
      number("gyro_bias_walk", "rad/s²/sqrt(Hz)", &noise.gyro_bias_walk, 0.0, kHuge,
             "how fast the gyro's bias wanders"),
      number("accelerometer_bias_walk", "m/s³/sqrt(Hz)", &noise.accelerometer_bias_walk, 0.0, kHuge,
             "how fast the accelerometer's bias wanders"),
      number("gyro_bias_sigma", "rad/s", &noise.gyro_bias_sigma, kTiny, kHuge,
             "of the gyro's bias before anything is known"),
      number("accelerometer_bias_sigma", "m/s²", &noise.accelerometer_bias_sigma, kTiny, kHuge,
             "of the accelerometer's bias before anything is known"),
      number("mounting_sigma", "rad", &noise.mounting_sigma_rad, 0.0, 1.0,
             "of roll and pitch of the IMU on the vehicle"),
      number("gyro_range", "rad/s", &noise.gyro_range, kTiny, kHuge,
             "readings of this size are saturated"),
      number("accelerometer_range", "m/s²", &noise.accelerometer_range, kTiny, kHuge,
             "readings of this size are saturated"),
      number("max_imu_rate", "Hz", &imu.max_rate_hz, 50.0, 2000.0, "denser readings are averaged"),
      number("min_imu_rate", "Hz", &imu.min_rate_hz, kTiny, 2000.0,
             "below, diagnostics warn of the coarse integration"),
      number("imu_frozen_time", "s", &imu.frozen_s, kTiny, kHuge,
             "identical readings for this long are not used"),
      number("imu_silent_time", "s", &imu.silent_s, kTiny, kHuge,
             "after this long without a reading the IMU is silent"),
      number("imu_max_gap", "s", &imu.max_gap_s, kTiny, kHuge,
             "after a longer gap the attitude begins anew"),
      number("max_gyro_bias", "rad/s", &filter.max_gyro_bias, kTiny, kHuge,
             "a larger estimate means a broken gyro: the filter starts anew"),
      number("max_accelerometer_bias", "m/s²", &filter.max_accelerometer_bias, kTiny, kHuge,
             "a larger estimate means a broken accelerometer: the filter starts anew"),
  };
}

std::vector<Parameter> fusionParametersOf(PoseFilterConfig& filter) {
  GateConfig& gate = filter.gate;
  HeightFusionConfig& height = filter.height;
  MotionConfig& motion = filter.motion;
  return {
      number("gate_probability", "", &gate.probability, 0.5, 1.0 - kTiny,
             "share of the right measurements that pass their gate"),
      number("history", "s", &gate.history_s, 0.05, 10.0, "later measurements come too late"),
      number(
          "reinitialize_after", "s", &gate.reinitialize_after_s, kTiny, kHuge,
          "poses that are refused for this long in a row are right: the map has corrected itself"),
      number("max_reinitializations", "", &gate.max_reinitializations, 1.0, kHuge,
             "so many of these within diverged_time: the filter has diverged and starts anew"),
      number("diverged_time", "s", &gate.diverged_s, kTiny, kHuge,
             "time that max_reinitializations counts"),
      number("coast_after", "s", &gate.coast_after_s, kTiny, kHuge,
             "after this long without a pose or position the state is coasting"),
      number("range_sigma", "m", &height.range_sigma_m, kTiny, kHuge,
             "of a reading of the range finder"),
      number("range_max", "m", &height.range_max_m, kTiny, kHuge, "longer readings are wrong"),
      number("floor_beam_sigma", "m", &height.floor_beam_sigma_m, kTiny, kHuge,
             "of a height that the projector measures"),
      number("barometer_sigma", "m", &height.barometer_sigma_m, kTiny, kHuge,
             "of a reading of the barometer"),
      number("barometer_drift", "m/sqrt(s)", &height.barometer_drift, 0.0, kHuge,
             "how fast the barometer's offset wanders"),
      number("height_sigma", "m", &height.initial_sigma_m, kTiny, kHuge,
             "of the height before anything measures it"),
      number("step_readings", "", &height.step_readings, 1.0, kHuge,
             "so many readings of the range finder in a row that agree are a table"),
      number("gravity_sigma", "m/s²", &motion.gravity_sigma, 0.0, kHuge,
             "of the vehicle's own acceleration, where gravity is measured; 0: it is not"),
      number("gravity_gate", "", &motion.gravity_gate, 0.0, 1.0,
             "share by which the acceleration may differ from gravity to be used"),
      number("gravity_period", "s", &motion.gravity_period_s, kTiny, kHuge,
             "time between two measurements of gravity"),
      flag("zero_velocity", &motion.zero_velocity, "a standstill says that the velocity is zero"),
      number("zero_velocity_sigma", "m/s", &motion.zero_velocity_sigma, kTiny, kHuge,
             "of the velocity at a standstill"),
      number("start_speed_sigma", "m/s", &motion.start_speed_sigma, kTiny, kHuge,
             "of the velocity of a start in the air"),
      number("yaw_sigma", "rad", &filter.yaw_sigma_rad, kTiny, kHuge, "of a magnetometer's yaw"),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(PoseFilterConfig& config) {
  std::vector<Parameter> all = imuParametersOf(config);
  std::vector<Parameter> more = fusionParametersOf(config);
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  return all;
}

}  // namespace kestrel
