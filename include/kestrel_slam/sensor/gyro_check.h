// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// How two measurements of the same rotations compare.
enum class RotationVerdict {
  kUnknown,     ///< too little rotation so far
  kAgree,       ///< same direction, similar size
  kDegrees,     ///< the first is 57 times larger: degrees instead of rad
  kFirstZero,   ///< only the second rotates
  kSecondZero,  ///< only the first rotates
  kOpposite,    ///< opposite directions
  kDifferent    ///< unrelated
};

/// Sums over pairs of rotations (rotation vectors, rad) that two sensors measured at the same time.
/// Old pairs fade out.
class RotationComparison {
 public:
  /// Adds a pair.
  void add(const Eigen::Vector3d& first, const Eigen::Vector3d& second);
  RotationVerdict verdict() const;
  void restart() { *this = RotationComparison(); }

 private:
  int pairs_ = 0;
  double first_path_ = 0.0, second_path_ = 0.0;  ///< sums of the norms, rad
  double first_squares_ = 0.0, second_squares_ = 0.0, products_ = 0.0;
};

/// Compares the gyro of an IMU with its orientation. Both describe the same rotation, so a wrong
/// unit or sign shows as soon as the vehicle turns.
class GyroCheck {
 public:
  /// Adds a reading in the order of the stamps.
  void add(const ImuSample& sample);

  RotationVerdict verdict() const { return verdict_; }
  /// True if the gyro claims much more rotation than the orientation in the newest readings, or
  /// none at all. Such readings are not used while the reason is not known yet.
  bool doubts() const { return doubts_; }

  /// Forgets the sums after a reading that is garbage. Only a known unit is kept.
  void interrupt();
  void restart() { *this = GyroCheck(); }

 private:
  bool isDoubtful(const Eigen::Vector3d& turned) const;
  void addStep(const Eigen::Vector3d& gyro, const Eigen::Vector3d& orientation);

  std::optional<ImuSample> last_;
  Eigen::Quaterniond step_start_ = Eigen::Quaterniond::Identity();
  double step_s_ = 0.0;
  Eigen::Vector3d step_gyro_ = Eigen::Vector3d::Zero();  ///< integrated in this step, rad
  RotationComparison steps_;       ///< of short steps: finds wrong units quickly
  RotationComparison long_steps_;  ///< a delay of the orientation does not matter
  int summed_ = 0;                 ///< steps in the sums below
  Eigen::Vector3d gyro_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d orientation_sum_ = Eigen::Vector3d::Zero();
  RotationVerdict verdict_ = RotationVerdict::kUnknown;
  bool doubts_ = false;
};

}  // namespace kestrel
