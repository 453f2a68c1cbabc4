// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// Joins a gyro and an accelerometer that send separate messages (depth cameras do this). Each
/// reading of the gyro gets the specific force at its stamp, interpolated between the two nearest
/// readings of the accelerometer. So it waits for the next one.
class ImuJoiner {
 public:
  /// Stamps in s. A reading that is not newer than the one before is ignored. Both vectors are in
  /// the same frame.
  void addGyro(double stamp, const Eigen::Vector3d& angular_velocity);
  void addAccelerometer(double stamp, const Eigen::Vector3d& specific_force);

  /// The readings that are complete now, in the order of their stamps. A reading without an
  /// accelerometer reading nearby has no specific force.
  std::vector<ImuSample> take();
  /// What is still waiting, without specific force.
  std::vector<ImuSample> finish();

 private:
  struct Reading {
    double stamp;
    Eigen::Vector3d value;
  };

  std::deque<Reading> gyro_, accelerometer_;
};

}  // namespace kestrel
