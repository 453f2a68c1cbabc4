// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/arrival_order.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/sensor/imu_validation.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

/// A stamp that differs more from the previous stamps does not change the clock, s.
constexpr double kMaxJump = 10.0;

double endOf(const RecordedScan& scan) {
  return (scan.cloud ? sweepTimes(*scan.cloud) : sweepTimes(scan.scan)).last;
}

}  // namespace

void ArrivalOrder::arrive(double stamp, ArrivingMessage& message) {
  if (!now_) now_ = stamp;
  if (std::abs(stamp - *now_) < kMaxJump) now_ = std::max(*now_, stamp);
  message.arrival = *now_;
}

bool ArrivalOrder::next(ArrivingMessage& message) {
  const bool is_due = due_ && (!newest_imu_ || *newest_imu_ < *due_);
  if (with_imu_ && (is_due || scans_ended_) && nextReading(message)) return true;
  if (scans_ended_) return false;
  RecordedScan scan;
  if (!recording_.next(scan)) {
    scans_ended_ = true;
    return next(message);
  }
  due_ = endOf(scan);
  now_ = now_ && std::abs(*due_ - *now_) < kMaxJump ? std::max(*now_, *due_) : *due_;
  message.arrival = *now_;
  message.message = std::move(scan);
  return true;
}

/// Ignores a single wrong stamp when it updates the newest reading.
void ArrivalOrder::noteStamp(double stamp) {
  if (faultOfStamp(stamp)) return;
  const StampCheck::Verdict verdict = stamp_check_.check(stamp);
  const bool is_newest =
      verdict == StampCheck::Verdict::kNext || verdict == StampCheck::Verdict::kSetBack;
  if (is_newest) newest_imu_ = stamp;
}

/// Returns the next reading of the IMU or the range finder.
bool ArrivalOrder::nextReading(ArrivingMessage& message) {
  const std::vector<ImuSample>& imu = recording_.imu().samples;
  const std::vector<HeightSample>& heights = recording_.heights();
  if (next_imu_ >= imu.size()) return false;
  const ImuSample& sample = imu[next_imu_];
  if (next_height_ < heights.size() && heights[next_height_].stamp <= sample.stamp) {
    message.message = heights[next_height_];
    arrive(heights[next_height_++].stamp, message);
    return true;
  }
  ++next_imu_;
  noteStamp(sample.stamp);
  message.message = sample;
  arrive(sample.stamp, message);
  return true;
}

}  // namespace kestrel
