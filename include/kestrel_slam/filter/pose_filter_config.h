// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace kestrel {

/// What is known of the IMU's errors. The defaults are those of an Xsens MTi's data sheet.
struct ImuNoiseConfig {
  double gyro_noise = 0.0009;              ///< density, rad/s/sqrt(Hz); > 0
  double accelerometer_noise = 0.002;      ///< density, m/s²/sqrt(Hz); > 0
  double gyro_bias_walk = 0.00002;         ///< rad/s²/sqrt(Hz); >= 0
  double accelerometer_bias_walk = 1e-4;   ///< m/s³/sqrt(Hz); >= 0
  double gyro_bias_sigma = 0.01;           ///< before anything is known, rad/s; > 0
  double accelerometer_bias_sigma = 0.03;  ///< the same, m/s²; > 0
  double mounting_sigma_rad = 0.002;       ///< of roll and pitch of the IMU on the base; >= 0
  double gyro_range = 34.9;                ///< readings of this size are saturated, rad/s; > 0
  double accelerometer_range = 156.9;      ///< the same, m/s²; > 0
};

/// When an IMU is no longer believed, and how dense its samples are used.
struct ImuInputConfig {
  double max_rate_hz = 500.0;  ///< denser samples are averaged; 50 to 2000
  double min_rate_hz = 50.0;   ///< below, the status warns of the coarse integration; > 0
  double frozen_s = 0.5;       ///< identical readings for this long are no readings; > 0
  double silent_s = 0.25;      ///< after this long without a sample the IMU is silent; > 0
  double max_gap_s = 1.0;      ///< after a longer gap the attitude begins anew; > silent_s
};

/// How measurements are judged.
struct GateConfig {
  double probability = 0.999;  ///< share of right measurements that pass (chi-square); 0 to 1
  double history_s = 1.0;      ///< later measurements come too late; 0.05 to 10
  double reinitialize_after_s =
      1.0;                        ///< poses that are rejected for this long in a row are right, and
                                  ///< the filter takes them over (the mapper has found itself); > 0
  double coast_after_s = 0.5;     ///< without an accepted pose or position the filter coasts; > 0
  int max_reinitializations = 3;  ///< so many take-overs within diverged_s: the filter has diverged
  double diverged_s = 20.0;       ///< s; > 0
};

/// Range finder, barometer and floor beams.
struct HeightFusionConfig {
  double range_sigma_m = 0.02;       ///< of a reading of the range finder; > 0
  double range_max_m = 50.0;         ///< longer readings are wrong; > 0
  double floor_beam_sigma_m = 0.05;  ///< of the height by the laser's own floor beams; > 0
  double barometer_sigma_m = 0.1;    ///< of one reading; > 0
  double barometer_drift = 0.02;     ///< random walk of its offset, m/sqrt(s); >= 0
  double initial_sigma_m = 2.0;      ///< of the height before anything measures it; > 0
  int step_readings = 2;             ///< so many readings in a row that agree are a table; >= 1
};

/// What may be assumed of the motion.
struct MotionConfig {
  double gravity_sigma = 1.0;  ///< of the vehicle's own acceleration, m/s²; 0: no gravity update
  double gravity_gate = 0.1;   ///< share by which |acceleration| may differ from g; 0 to 1
  double gravity_period_s = 0.5;      ///< time between two gravity updates; > 0
  bool zero_velocity = true;          ///< a standstill says that the velocity is zero
  double zero_velocity_sigma = 0.01;  ///< m/s; > 0
  double start_speed_sigma = 1.0;     ///< of a start in the air, m/s; > 0
};

/// All parameters of the pose filter. The defaults live here and nowhere else.
struct PoseFilterConfig {
  ImuNoiseConfig noise;
  ImuInputConfig imu;
  GateConfig gate;
  HeightFusionConfig height;
  MotionConfig motion;
  double yaw_sigma_rad = 0.1;  ///< least deviation that a magnetometer's yaw has; > 0
  double max_gyro_bias = 0.5;  ///< a larger estimate is a broken gyro or filter, rad/s; > 0
  double max_accelerometer_bias = 3.0;  ///< the same, m/s²; > 0
};

/// Throws std::invalid_argument with the name and the limits of the first value that is outside.
void validate(const PoseFilterConfig& config);

}  // namespace kestrel
