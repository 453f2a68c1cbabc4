// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {

/// One step of the IMU: the mean of its readings (trapezoidal) since the step before.
struct ImuStep {
  double stamp = 0.0;
  double dt = 0.0;   ///< s; 0: the first reading
  ImuInput mean;     ///< over the step
  ImuInput reading;  ///< at its end
};

/// Validates samples of an IMU, turns them into the base, and thins those that come too densely.
class ImuIntake {
 public:
  enum class Result { kStep, kMerged, kRejected, kClockSetBack };

  explicit ImuIntake(const PoseFilterConfig& config);

  /// kStep: `step` is set. kRejected: `fault` is. kClockSetBack: the sample begins a new time.
  Result add(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu);

  const ImuStep& step() const { return step_; }
  const ImuFault& fault() const { return fault_; }  ///< of the last rejected sample
  std::optional<double> newest() const;             ///< stamp of the last sample that was used
  bool isBad() const { return bad_; }               ///< the last sample was rejected
  double rate() const;                              ///< of the samples, smoothed, Hz

 private:
  bool isUsable(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu);
  ImuInput inBase(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) const;
  Result accumulate(double stamp, const ImuInput& reading);

  PoseFilterConfig config_;
  FrozenCheck frozen_;
  StampCheck stamps_;
  ImuFault fault_;
  bool bad_ = false;
  ImuStep step_;
  Eigen::Vector3d lever_m_ = Eigen::Vector3d::Zero();  ///< of the IMU in base
  std::optional<double> last_stamp_;
  ImuInput last_;
  ImuInput sum_;           ///< times seconds, of the readings since the last step
  double period_s_ = 0.0;  ///< smoothed
};

}  // namespace kestrel
