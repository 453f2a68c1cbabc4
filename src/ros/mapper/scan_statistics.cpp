// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/scan_statistics.h"

#include <algorithm>

namespace kestrel {

using Lock = std::lock_guard<std::mutex>;

namespace {

/// No scan for so long, in s and in times of the interval of the scans, is a silence.
constexpr double kSilence = 1.0, kSilentIntervals = 3.0;

}  // namespace

void ScanStatistics::received() {
  const Lock lock(mutex_);
  ++report_.received;
  if (last_received_) interval_s_ = silence();
  last_received_ = Clock::now();
}

void ScanStatistics::dropped(const std::string& reason, std::size_t count) {
  if (count == 0) return;
  const Lock lock(mutex_);
  report_.dropped[reason] += count;
  report_.dropped_lately += count;
  report_.last_reason = reason;
}

void ScanStatistics::used(const MapperResult& result, double ms) {
  const Lock lock(mutex_);
  ++report_.used;
  report_.state = result.state;
  report_.reason = result.reason;
  report_.score = result.match.score;
  report_.degenerate = result.match.degenerate;
  report_.map_full = result.map_full;
  ++timed_;
  total_ms_ += ms;
  report_.max_ms = std::max(report_.max_ms, ms);
}

void ScanStatistics::setPaused(bool paused) {
  const Lock lock(mutex_);
  report_.paused = paused;
}

bool ScanStatistics::paused() const {
  const Lock lock(mutex_);
  return report_.paused;
}

void ScanStatistics::setWaitingFor(const std::string& what) {
  const Lock lock(mutex_);
  report_.waiting_for = what;
}

/// Since the last scan, s.
double ScanStatistics::silence() const {
  return std::chrono::duration<double>(Clock::now() - *last_received_).count();
}

bool ScanStatistics::isStale() const {
  return last_received_ && silence() > std::max(kSilence, kSilentIntervals * interval_s_);
}

bool ScanStatistics::stale() const {
  const Lock lock(mutex_);
  return isStale();
}

ScanReport ScanStatistics::take() {
  const Lock lock(mutex_);
  ScanReport report = report_;
  if (timed_ > 0) report.mean_ms = total_ms_ / static_cast<double>(timed_);
  if (last_received_) report.silence_s = silence();
  report.stale = isStale();
  timed_ = 0;
  total_ms_ = 0.0;
  report_.max_ms = 0.0;
  report_.dropped_lately = 0;
  return report;
}

}  // namespace kestrel
