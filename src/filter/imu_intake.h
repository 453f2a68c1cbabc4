// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "filter_state.h"
#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {

/// One IMU step: the mean (trapezoidal) of the readings since the previous step.
struct ImuStep {
  double stamp = 0.0;
  double dt = 0.0;        ///< s; 0 for the first reading
  InertialInput mean;     ///< over the step, in the base frame
  InertialInput reading;  ///< at the end of the step, in the base frame
};

/// Validates IMU samples, converts them to the base frame, and averages them at high rates.
class ImuIntake {
 public:
  enum class Result { kStep, kMerged, kRejected, kClockSetBack };

  explicit ImuIntake(const PoseFilterConfig& config);

  /// Adds a sample. kStep: step() is new. kMerged: the sample is part of the next step. kRejected:
  /// see fault(). kClockSetBack: the clock was set back; step() is the first of the new time.
  Result add(const CheckedImu& reading);

  const ImuStep& step() const { return step_; }
  const ImuFault& fault() const { return fault_; }  ///< of the last rejected sample
  std::optional<double> newest() const;             ///< stamp of the last used sample, s
  bool isBad() const { return bad_; }               ///< the last sample was invalid or frozen
  double rate() const;                              ///< rate of the samples, smoothed, Hz

 private:
  std::optional<ImuFault> faultIn(const CheckedImu& reading) const;
  InertialInput inBase(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu) const;
  Result accumulate(double stamp, const InertialInput& reading);

  PoseFilterConfig config_;
  ImuFault fault_;
  bool bad_ = false;
  ImuStep step_;
  Eigen::Vector3d lever_m_ = Eigen::Vector3d::Zero();  ///< position of the IMU in the base frame
  std::optional<double> last_stamp_;
  InertialInput last_;
  InertialInput sum_;      ///< integral of the readings since the last step
  double period_s_ = 0.0;  ///< smoothed
};

}  // namespace kestrel
