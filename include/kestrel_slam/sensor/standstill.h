// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>

namespace kestrel {

/// Recognizes a vehicle that stands still by a second of readings that hardly vary: what the gyro
/// says then is its bias, about the vertical too, which gravity does not show.
class Standstill {
 public:
  /// Takes a reading, `dt` seconds after the one before. Returns the gyro's mean over the last
  /// second where that second was a standstill.
  std::optional<Eigen::Vector3d> add(double dt, const Eigen::Vector3d& rate,
                                     const Eigen::Vector3d& force);
  void restart() { *this = Standstill(); }

 private:
  std::optional<Eigen::Vector3d> judge() const;

  int count_ = 0;
  double time_s_ = 0.0;
  Eigen::Vector3d rate_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d rate_offset_ = Eigen::Vector3d::Zero();  ///< sums are relative to the first
  Eigen::Vector3d force_offset_ = Eigen::Vector3d::Zero();
  double rate_squares_ = 0.0;
  double force_squares_ = 0.0;
};

}  // namespace kestrel
