// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// Errors of the IMU. The defaults are from the data sheet of an Xsens MTi.
struct ImuNoiseConfig {
  double gyro_noise = 0.0009;              ///< density, rad/s/sqrt(Hz); > 0
  double accelerometer_noise = 0.002;      ///< density, m/s²/sqrt(Hz); > 0
  double gyro_bias_walk = 0.00002;         ///< rad/s²/sqrt(Hz); >= 0
  double accelerometer_bias_walk = 1e-4;   ///< m/s³/sqrt(Hz); >= 0
  double gyro_bias_sigma = 0.01;           ///< initial uncertainty, rad/s; > 0
  double accelerometer_bias_sigma = 0.03;  ///< initial uncertainty, m/s²; > 0
  double mounting_sigma_rad = 0.002;       ///< of roll and pitch of the IMU on the base; >= 0
  double gyro_range = 34.9;                ///< readings of this size are saturated, rad/s; > 0
  double accelerometer_range = 156.9;      ///< readings of this size are saturated, m/s²; > 0
};

/// Limits for IMU samples and their rate.
struct ImuInputConfig {
  double max_rate_hz = 500.0;  ///< samples at higher rates are averaged; 50 to 2000
  double min_rate_hz = 50.0;   ///< below, the status warns that the integration is inaccurate; > 0
  double frozen_s = 0.5;       ///< identical readings for this long are rejected; > 0
  double silent_s = 0.25;      ///< the IMU counts as silent after this time without a sample; > 0
  double max_gap_s = 1.0;      ///< after a longer gap the attitude is initialized again; > silent_s
};

/// How measurements are accepted or rejected.
struct GateConfig {
  /// Share of correct measurements that pass the gate (chi-square); 0 to 1.
  double probability = 0.999;
  double history_s = 1.0;  ///< older measurements are rejected; 0.05 to 10
  /// If poses are rejected for this long in a row, the filter is reinitialized to them (the mapper
  /// has recovered its pose); > 0.
  double reinitialize_after_s = 1.0;
  /// The filter coasts after this time without an accepted pose or position; > 0.
  double coast_after_s = 0.5;
  /// After this many reinitializations within diverged_s the filter is reset.
  int max_reinitializations = 3;
  double diverged_s = 20.0;  ///< s; > 0
};

/// Range finder, barometer and floor beams.
struct HeightFusionConfig {
  double range_sigma_m = 0.02;       ///< of a reading of the range finder; > 0
  double range_max_m = 50.0;         ///< longer readings are rejected; > 0
  double floor_beam_sigma_m = 0.05;  ///< of a height from floor beams of the laser; > 0
  double barometer_sigma_m = 0.1;    ///< of one reading; > 0
  double barometer_drift = 0.02;     ///< random walk of its offset, m/sqrt(s); >= 0
  double initial_sigma_m = 2.0;      ///< of the height before the first measurement; > 0
  /// A step (table) is accepted after this many consistent readings in a row; >= 1.
  int step_readings = 2;
};

/// Assumptions on the motion.
struct MotionConfig {
  /// Standard deviation of the acceleration of the vehicle, m/s²; 0: no gravity updates.
  double gravity_sigma = 1.0;
  double gravity_gate = 0.1;  ///< allowed relative difference between |acceleration| and g; 0 to 1
  double gravity_period_s = 0.5;      ///< period of gravity updates; > 0
  bool zero_velocity = true;          ///< use zero velocity updates at a standstill
  double zero_velocity_sigma = 0.01;  ///< m/s; > 0
  double start_speed_sigma = 1.0;     ///< speed uncertainty if initialized in flight, m/s; > 0
};

/// All parameters of the pose filter. All defaults are defined here.
struct PoseFilterConfig {
  ImuNoiseConfig noise;
  ImuInputConfig imu;
  GateConfig gate;
  HeightFusionConfig height;
  MotionConfig motion;
  double yaw_sigma_rad = 0.1;  ///< minimum standard deviation of a magnetometer's yaw; > 0
  /// A larger estimate resets the filter (broken gyro, or diverged), rad/s; > 0.
  double max_gyro_bias = 0.5;
  double max_accelerometer_bias = 3.0;  ///< a larger estimate resets the filter, m/s²; > 0
};

/// Throws std::invalid_argument with the name and the limits of the first invalid parameter.
void validate(const PoseFilterConfig& config);

}  // namespace kestrel
