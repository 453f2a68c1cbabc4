// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/parameters/filter_parameters.h"

#include "kestrel_slam/parameters/parameter_table.h"

namespace kestrel {
namespace {

using namespace parameter_table;

std::vector<Parameter> noiseParametersOf(ImuNoiseConfig& noise) {
  return {
      number("gyro_noise", "rad/s/sqrt(Hz)", &noise.gyro_noise, 1e-6, 1.0,
             "Noise density of the gyro, from its data sheet; with a larger value the filter "
             "trusts the gyro less."),
      number("accelerometer_noise", "m/s²/sqrt(Hz)", &noise.accelerometer_noise, 1e-6, 10.0,
             "Noise density of the accelerometer, from its data sheet; with a larger value the "
             "filter trusts the accelerometer less."),
      number("gyro_bias_walk", "rad/s²/sqrt(Hz)", &noise.gyro_bias_walk, 0.0, 1.0,
             "Random walk of the gyro's bias; a larger value lets the estimated bias change "
             "faster."),
      number("accelerometer_bias_walk", "m/s³/sqrt(Hz)", &noise.accelerometer_bias_walk, 0.0, 10.0,
             "Random walk of the accelerometer's bias; a larger value lets the estimated bias "
             "change faster."),
      number("gyro_bias_sigma", "rad/s", &noise.gyro_bias_sigma, 1e-6, 10.0,
             "Standard deviation of the gyro's bias when the filter starts."),
      number("accelerometer_bias_sigma", "m/s²", &noise.accelerometer_bias_sigma, 1e-6, 10.0,
             "Standard deviation of the accelerometer's bias when the filter starts."),
      number("mounting_sigma", "rad", &noise.mounting_sigma_rad, 0.0, 1.0,
             "Standard deviation of roll and pitch of the IMU's mounting; it is added to the "
             "published covariance."),
  };
}

std::vector<Parameter> imuParametersOf(PoseFilterConfig& filter) {
  ImuInputConfig& imu = filter.imu;
  return {
      number("gyro_range", "rad/s", &filter.noise.gyro_range, 0.1, 1000.0,
             "Largest rate that the gyro can measure; readings of this size are saturated and "
             "trusted much less."),
      number("accelerometer_range", "m/s²", &filter.noise.accelerometer_range, 10.0, 10000.0,
             "Largest acceleration that the accelerometer can measure; readings of this size are "
             "saturated and trusted much less."),
      number("max_imu_rate", "Hz", &imu.max_rate_hz, 50.0, 2000.0,
             "Readings that come faster are averaged to this rate; a larger value needs more "
             "time."),
      number("min_imu_rate", "Hz", &imu.min_rate_hz, 1.0, 2000.0,
             "Rate below which the diagnostics warn that the IMU is too slow."),
      number("imu_frozen_time", "s", &imu.frozen_s, 0.01, 1000.0,
             "Time after which an IMU that repeats the same reading is no longer used."),
      number("imu_silent_time", "s", &imu.silent_s, 0.01, 1000.0,
             "Time without a reading after which the IMU is reported as silent."),
      number("imu_max_gap", "s", &imu.max_gap_s, 0.01, 1000.0,
             "Longest time between two readings that is integrated; after a longer gap the filter "
             "restarts."),
      number("max_gyro_bias", "rad/s", &filter.max_gyro_bias, 0.001, 100.0,
             "Largest estimated gyro bias; above it the gyro is broken and the filter restarts."),
      number("max_accelerometer_bias", "m/s²", &filter.max_accelerometer_bias, 0.01, 100.0,
             "Largest estimated accelerometer bias; above it the accelerometer is broken and the "
             "filter restarts."),
  };
}

std::vector<Parameter> gateParametersOf(GateConfig& gate) {
  return {
      number("gate_probability", "", &gate.probability, 0.5, 0.999999,
             "Share of the correct measurements that pass the outlier gate; a larger value "
             "accepts larger errors."),
      number("history", "s", &gate.history_s, 0.05, 10.0,
             "Age up to which late measurements are used; a larger value needs more memory."),
      renamed("anchor_after",
              number("reinitialize_after", "s", &gate.reinitialize_after_s, 0.001, 1000.0,
                     "Time after which the filter moves to poses that it has refused all the time: "
                     "the map has corrected itself.")),
      renamed("max_anchors",
              number("max_reinitializations", "", &gate.max_reinitializations, 1.0, kNoLimit,
                     "Number of reinitializations within diverged_time after which the filter has "
                     "diverged and restarts.")),
      number("diverged_time", "s", &gate.diverged_s, 0.001, 1e6,
             "Time within which max_reinitializations are counted."),
      number("coast_after", "s", &gate.coast_after_s, 0.001, 1000.0,
             "Time without an accepted pose or position after which the filter reports that it is "
             "coasting."),
  };
}

std::vector<Parameter> heightParametersOf(HeightFusionConfig& height) {
  return {
      number("range_sigma", "m", &height.range_sigma_m, 0.0001, 100.0,
             "Standard deviation of a reading of the range finder."),
      number("range_max", "m", &height.range_max_m, 0.1, 10000.0,
             "Longest valid reading of the range finder; longer ones are refused."),
      number("step_readings", "", &height.step_readings, 1.0, kNoLimit,
             "Number of readings in a row that must agree after a jump of the range before the "
             "filter takes it for a step in the ground, such as a table."),
      number("floor_beam_sigma", "m", &height.floor_beam_sigma_m, 0.0001, 100.0,
             "Standard deviation of a height that the projector measures with beams on the "
             "floor."),
      number("barometer_sigma", "m", &height.barometer_sigma_m, 0.0001, 100.0,
             "Standard deviation of a height of the barometer."),
      number("barometer_drift", "m/sqrt(s)", &height.barometer_drift, 0.0, 100.0,
             "Random walk of the barometer's offset; a larger value trusts the barometer less "
             "over long times."),
      number("height_sigma", "m", &height.initial_sigma_m, 0.0001, 1000.0,
             "Standard deviation of the height before any sensor measures it."),
  };
}

std::vector<Parameter> motionParametersOf(PoseFilterConfig& filter) {
  MotionConfig& motion = filter.motion;
  return {
      number("gravity_sigma", "m/s²", &motion.gravity_sigma, 0.0, 100.0,
             "Standard deviation of the vehicle's own acceleration if the direction of gravity is "
             "used as a measurement; 0: it is not used."),
      number("gravity_gate", "", &motion.gravity_gate, 0.0, 1.0,
             "Largest relative difference between acceleration and gravity at which the direction "
             "of gravity is used."),
      number("gravity_period", "s", &motion.gravity_period_s, 0.001, 1000.0,
             "Time between two measurements of the direction of gravity."),
      flag("zero_velocity", &motion.zero_velocity,
           "Use a standstill, which the IMU shows, as a measurement of zero velocity."),
      number("zero_velocity_sigma", "m/s", &motion.zero_velocity_sigma, 0.0001, 100.0,
             "Standard deviation of the velocity at a standstill."),
      number("start_speed_sigma", "m/s", &motion.start_speed_sigma, 0.0001, 1000.0,
             "Standard deviation of the velocity when the filter starts in flight."),
      renamed("heading_sigma", number("yaw_sigma", "rad", &filter.yaw_sigma_rad, 0.0001, 10.0,
                                      "Smallest standard deviation of a magnetometer's yaw.")),
  };
}

}  // namespace

std::vector<Parameter> parametersOf(PoseFilterConfig& config) {
  return joined({group("IMU noise", noiseParametersOf(config.noise)),
                 group("IMU input", imuParametersOf(config)),
                 group("Outliers and late measurements", gateParametersOf(config.gate)),
                 group("Height", heightParametersOf(config.height)),
                 group("Gravity, standstill and yaw", motionParametersOf(config))});
}

}  // namespace kestrel
