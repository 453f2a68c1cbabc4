// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/mapping/odometry_model.h"

namespace kestrel {

/// Time constant of the smoothed velocity, s. Of an error of the velocity, a match t after the last
/// one leaves the share kVelocityTime / (t + kVelocityTime).
constexpr double kVelocityTime = 0.15;

/// The source of a motion prediction.
enum class PredictionSource { kVelocity, kAccelerometer, kOdometry };

/// A step of a motion that is only predicted.
struct PredictedStep {
  double seconds = 0.0;
  Pose2 motion;  ///< predicted, in the base frame at the beginning of the step
  PredictionSource source = PredictionSource::kVelocity;
  bool yaw_measured = false;  ///< by a gyro, a pose filter or the odometry
  MotionError odometry;       ///< error of `motion`, if the odometry is the source
};

/// The error of a pose that is predicted over several steps without a match. Errors of a prediction
/// have the same sign over many steps, so standard deviations are added, not variances.
class PredictionError {
 public:
  PredictionError() = default;
  /// The error of a measured motion.
  explicit PredictionError(const MotionError& measured)
      : position_m_(measured.position_m), yaw_rad_(measured.yaw_rad) {}

  void grow(const PredictedStep& step);

  double position_m() const { return position_m_; }  ///< standard deviation along x and along y, m
  double yaw_rad() const { return yaw_rad_; }        ///< standard deviation, rad
  double speed_m_s() const { return speed_m_s_; }    ///< standard deviation of the velocity, m/s

 private:
  void growYaw(const PredictedStep& step);

  double position_m_ = 0.0, yaw_rad_ = 0.0;
  double speed_m_s_ = 0.0, rate_rad_s_ = 0.0;  ///< of the velocity and of the yaw rate
};

}  // namespace kestrel
