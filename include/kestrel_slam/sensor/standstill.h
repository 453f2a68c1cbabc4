// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel {

/// Detects a standstill: one second of readings that hardly vary. The mean of the gyro is then its
/// bias, including the bias about the vertical, which gravity does not show.
class Standstill {
 public:
  /// Adds a reading. `dt`: time since the previous one, s; `rate`: rad/s; `force`: specific force,
  /// m/s². Returns the mean rate over the last second if that second was a standstill.
  std::optional<Eigen::Vector3d> add(double dt, const Eigen::Vector3d& rate,
                                     const Eigen::Vector3d& force);
  void restart() { *this = Standstill(); }

 private:
  std::optional<Eigen::Vector3d> judge() const;

  int count_ = 0;
  double time_s_ = 0.0;
  Eigen::Vector3d rate_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  /// The sums are relative to the first reading.
  Eigen::Vector3d rate_offset_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_offset_ = Eigen::Vector3d::Zero();
  double rate_squares_ = 0.0;
  double force_squares_ = 0.0;
};

}  // namespace kestrel
