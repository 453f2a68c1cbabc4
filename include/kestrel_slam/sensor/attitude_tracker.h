// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "kestrel_slam/sensor/attitude_buffer.h"
#include "kestrel_slam/sensor/imu_sample.h"

namespace kestrel {

/// How attitudes are taken from an IMU. The defaults live here and nowhere else.
struct AttitudeConfig {
  AttitudeBufferConfig buffer;
  std::string source = "auto";  ///< auto: the orientation where the driver gives one, else raw;
                                ///< orientation; raw: from gyro and accelerometer
  double gravity_time_s = 4.0;  ///< raw: time constant with which gravity corrects the gyro
  double bias_time_s = 60.0;    ///< raw: time constant of the estimate of the gyro's bias
  double gravity_gate = 0.1;    ///< raw: share by which |acceleration| may differ from 9.81 m/s²
  double frozen_s = 0.5;        ///< identical readings for this long are no readings
  double silent_s = 0.5;        ///< after this long without a reading the IMU is silent
};

/// What the attitude can be trusted for.
enum class ImuHealth {
  kOk,
  kNoData,        ///< nothing has come yet
  kSilent,        ///< nothing has come for silent_s
  kFrozen,        ///< the same reading again and again
  kInvalid,       ///< the last readings were not finite, no unit quaternions, or went back in time
  kUpsideDown,    ///< the attitude says that the vehicle's z axis points down
  kContradiction  ///< orientation and accelerometer disagree on where down is (wrong mounting)
};

const char* toString(ImuHealth health);

struct ImuStatus {
  ImuHealth health = ImuHealth::kNoData;
  std::string message;  ///< a sentence for the user: what is wrong, with values, and what to do
  std::size_t received = 0;
  std::size_t used = 0;
  std::map<std::string, std::size_t> rejected;  ///< readings that were not used, by reason
  bool estimated = false;  ///< the attitude comes from gyro and accelerometer, not from the driver
};

/// Makes attitudes of the vehicle out of the readings of an IMU that may be mounted in any
/// orientation. Every reading is validated; whatever comes, what is in the buffer is finite, and
/// good readings after bad ones are used at once.
class AttitudeTracker {
 public:
  explicit AttitudeTracker(const AttitudeConfig& config = AttitudeConfig());
  ~AttitudeTracker();
  AttitudeTracker(AttitudeTracker&&) noexcept;
  AttitudeTracker& operator=(AttitudeTracker&&) noexcept;

  /// False where the reading is rejected. `base_R_imu`: the mounting.
  bool add(const ImuSample& sample, const Eigen::Quaterniond& base_R_imu);

  /// An attitude from elsewhere (tf), instead of IMU readings.
  bool addAttitude(double stamp, const Eigen::Quaterniond& world_R_base);

  const AttitudeBuffer& buffer() const;

  /// The status at `now`, on the clock of the stamps (s).
  ImuStatus status(double now) const;

  /// Forgets everything but the counts: for a clock that was set back.
  void restart();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
