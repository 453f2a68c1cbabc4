// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <variant>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {

/// One message of a recording with its simulated arrival time.
struct ArrivingMessage {
  double arrival = 0.0;  ///< arrival time on the clock of the stamps, s; never decreases
  std::variant<RecordedScan, ImuSample, HeightSample> message;
};

/// Sorts the messages of a recording into the order in which they arrive on a vehicle. A scan
/// arrives at the end of its sweep. It is followed by the IMU and range finder readings up to the
/// first IMU reading that is not older than the last beam.
class ArrivalOrder {
 public:
  /// `with_imu`: false returns only the scans.
  ArrivalOrder(Recording& recording, bool with_imu) : recording_(recording), with_imu_(with_imu) {}

  /// Returns false at the end of the recording. Passes on the exceptions of Recording::next.
  bool next(ArrivingMessage& message);

 private:
  bool nextReading(ArrivingMessage& message);
  void noteStamp(double stamp);
  void arrive(double stamp, ArrivingMessage& message);

  Recording& recording_;
  bool with_imu_;
  bool scans_ended_ = false;
  std::size_t next_imu_ = 0, next_height_ = 0;
  std::optional<double> due_;  ///< readings up to this time come before the next scan, s
  StampCheck stamp_check_;
  std::optional<double> newest_imu_;  ///< stamp, s
  std::optional<double> now_;
};

}  // namespace kestrel
