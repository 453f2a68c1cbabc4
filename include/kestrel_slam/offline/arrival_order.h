// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <variant>

#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/stamp_check.h"

namespace kestrel {

/// One message of a recording, as it would arrive on a vehicle.
struct ArrivingMessage {
  double arrival = 0.0;  ///< s, on the clock of the stamps; never decreases
  std::variant<RecordedScan, ImuSample, HeightSample> message;
};

/// The messages of a recording in the order in which they arrive on a vehicle: a scan at the end of
/// its sweep, then what the IMU and the range finder measured until then, up to the first reading
/// of the IMU that is not older than the last beam.
class ArrivalOrder {
 public:
  /// `with_imu` false: only the scans.
  ArrivalOrder(Recording& recording, bool with_imu) : recording_(recording), with_imu_(with_imu) {}

  /// False at the end. Throws what Recording::next throws.
  bool next(ArrivingMessage& message);

 private:
  bool nextReading(ArrivingMessage& message);
  void noteStamp(double stamp);
  void arrive(double stamp, ArrivingMessage& message);

  Recording& recording_;
  bool with_imu_;
  bool scans_ended_ = false;
  std::size_t next_imu_ = 0, next_height_ = 0;
  std::optional<double> due_;  ///< the readings until here come before the next scan, s
  StampCheck stamp_check_;
  std::optional<double> newest_imu_;  ///< stamp, s
  std::optional<double> now_;
};

}  // namespace kestrel
