// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "kestrel_slam/geometry/random.h"
#include "kestrel_slam/sensor/imu_sample.h"
#include "kestrel_slam/simulation/flight_simulator.h"
#include "kestrel_slam/simulation/motion.h"

namespace kestrel {

/// What an IMU in the origin of the base measures, reading after reading at its rate.
class ImuSimulator {
 public:
  ImuSimulator(const ImuModel& model, const Eigen::Quaterniond& base_R_imu, std::uint64_t seed);

  /// The next reading, in the state `truth`; its stamp is not set.
  ImuSample next(const TrueState& truth);

  const Eigen::Vector3d& gyroBias() const { return gyro_bias_; }                    ///< in the IMU
  const Eigen::Vector3d& accelerometerBias() const { return accelerometer_bias_; }  ///< the same

 private:
  Eigen::Vector3d normal(double sigma);
  /// One step of a Gauss-Markov process with the attitude's correlation time.
  double wander(double value, double sigma);

  ImuModel model_;
  Random random_;
  Eigen::Quaterniond base_R_imu_;  ///< as it really is mounted
  Eigen::Vector3d gyro_bias_, accelerometer_bias_;
  Eigen::Vector3d attitude_error_;  ///< roll and pitch in base, yaw in world, rad
};

}  // namespace kestrel
