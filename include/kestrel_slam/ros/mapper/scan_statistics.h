// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// Counts of scans since the start, and some values since the last report.
struct ScanReport {
  std::size_t received = 0;
  std::size_t used = 0;
  std::map<std::string, std::size_t> dropped;  ///< by reason
  std::size_t dropped_lately = 0;              ///< since the last report
  std::string last_reason;                     ///< of the newest drop
  double mean_ms = 0.0;  ///< per scan since the last report: projection, match and insertion
  double max_ms = 0.0;
  bool paused = false;
  std::string waiting_for;          ///< missing transform, or empty
  std::optional<double> silence_s;  ///< since the last scan; empty before the first
  bool stale = false;               ///< scans came, but do not come any more
  std::optional<MatchState> state;  ///< of the last used scan
  std::string reason;               ///< of this state
  double score = 0.0;
  bool degenerate = false;
  bool map_full = false;
};

/// Counts scans; every method may be called from any thread.
class ScanStatistics {
 public:
  void received();
  void dropped(const std::string& reason, std::size_t count = 1);
  void used(const MapperResult& result, double ms);
  void setPaused(bool paused);
  bool paused() const;
  /// Call this when scans wait for a missing transform. Empty text: no transform is missing.
  void setWaitingFor(const std::string& what);

  /// Whether scans came before, but none for a second, nor for three times as long as between the
  /// last two.
  bool stale() const;

  /// Returns the report, and resets the times and `dropped_lately`.
  ScanReport take();

 private:
  using Clock = std::chrono::steady_clock;

  double silence() const;
  bool isStale() const;

  mutable std::mutex mutex_;
  ScanReport report_;
  std::size_t timed_ = 0;  ///< scans since the last report
  double total_ms_ = 0.0;
  std::optional<Clock::time_point> last_received_;
  double interval_s_ = 0.0;  ///< between the last two scans
};

}  // namespace kestrel
