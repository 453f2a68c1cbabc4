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
#include "kestrel_slam/sensor/imu_validation.h"

namespace kestrel {

/// How attitudes are computed from an IMU. All defaults are defined here.
struct AttitudeConfig {
  AttitudeBufferConfig buffer;
  std::string source = "auto";  ///< auto: the driver's orientation if it gives one, else raw;
                                ///< orientation; raw: from gyro and accelerometer
  double gravity_time_s = 4.0;  ///< raw: time constant of the correction by gravity
  double bias_time_s = 60.0;    ///< raw: time constant of the gyro bias estimate
  /// Raw: allowed relative difference between |acceleration| and 9.81 m/s².
  double gravity_gate = 0.1;
  double frozen_s = 0.5;  ///< identical readings for this long are rejected
  double silent_s = 0.5;  ///< the IMU counts as silent after this time without a reading
};

/// State of the IMU.
enum class ImuHealth {
  kOk,
  kNoData,   ///< no reading has arrived yet
  kSilent,   ///< no reading for silent_s
  kFrozen,   ///< the same reading for frozen_s
  kInvalid,  ///< the last readings were not finite, not unit quaternions, or their stamps went back
  kUpsideDown,    ///< according to the attitude the z axis of the vehicle points down
  kContradiction  ///< the values of the IMU contradict each other: accelerometer and orientation
                  ///< on the direction of gravity (wrong mounting), or gyro and orientation
};

const char* toString(ImuHealth health);

struct ImuStatus {
  ImuHealth health = ImuHealth::kNoData;
  std::string reason;   ///< a short phrase for the problem
  std::string message;  ///< for the user: what is wrong, the values, and what to do
  std::size_t received = 0;
  std::size_t used = 0;
  std::map<std::string, std::size_t> rejected;  ///< number of rejected readings, by reason
  bool estimated = false;  ///< true: from gyro and accelerometer; false: the driver's orientation
};

/// Computes attitudes of the vehicle from the readings of an IMU that may be mounted in any
/// orientation. Every reading is validated: the buffer only holds finite values, and good readings
/// after bad ones are used at once.
class AttitudeTracker {
 public:
  explicit AttitudeTracker(const AttitudeConfig& config = AttitudeConfig());
  ~AttitudeTracker();
  AttitudeTracker(AttitudeTracker&&) noexcept;
  AttitudeTracker& operator=(AttitudeTracker&&) noexcept;

  /// Returns false if the reading is rejected. `base_R_imu`: mounting of the IMU.
  bool add(const ImuSample& sample, const Eigen::Quaterniond& base_R_imu);
  /// The same for a reading that was validated already.
  bool add(const CheckedImu& reading);

  /// Adds an attitude from another source (tf) instead of IMU readings. Returns false if it is
  /// rejected.
  bool addAttitude(double stamp, const Eigen::Quaterniond& world_R_base);

  const AttitudeBuffer& buffer() const;

  /// The status at `now` (s, same clock as the stamps).
  ImuStatus status(double now) const;

  /// Forgets everything except the counters. To be called if the clock was set back.
  void restart();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel
