// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "kestrel_slam/simulation/motion.h"

namespace kestrel {

/// Simulates the readings of an IMU in the origin of the base at its fixed rate.
class ImuSimulator {
 public:
  ImuSimulator(const ImuModel& model, const Eigen::Quaterniond& base_R_imu, std::uint64_t seed);

  /// The next reading, if the vehicle is in state `truth`. The stamp is not set.
  ImuSample next(const TrueState& truth);

  const Eigen::Vector3d& gyroBias() const { return gyro_bias_; }  ///< rad/s, in the IMU
  const Eigen::Vector3d& accelerometerBias() const { return accelerometer_bias_; }  ///< m/s², same

 private:
  Eigen::Vector3d normal(double sigma);
  /// One step of a first-order Gauss-Markov process with the attitude error's correlation time.
  double gaussMarkovStep(double value, double sigma);

  ImuModel model_;
  Random random_;
  Eigen::Quaterniond base_R_imu_;  ///< true mounting, with its error
  Eigen::Vector3d gyro_bias_, accelerometer_bias_;
  Eigen::Vector3d attitude_error_;  ///< roll and pitch in base, yaw in world, rad
};

}  // namespace kestrel
