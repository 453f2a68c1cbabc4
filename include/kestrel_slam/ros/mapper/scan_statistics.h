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

/// What happened to the scans so far, and since the last report.
struct ScanReport {
  std::size_t received = 0;
  std::size_t used = 0;
  std::map<std::string, std::size_t> dropped;  ///< by reason
  std::size_t dropped_lately = 0;              ///< since the last report
  std::string last_reason;                     ///< of the newest drop
  double mean_ms = 0.0;  ///< per scan since the last report: projection, match and insertion
  double max_ms = 0.0;
  bool paused = false;
  std::string waiting_for;          ///< what tf lacks, or empty
  std::optional<double> silence_s;  ///< since the last scan came; nothing before the first
  std::optional<MatchState> state;  ///< of the last used scan
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
  /// Scans come, and cannot be used for want of a transform; empty: they can again.
  void setWaitingFor(const std::string& what);

  /// The report, after which the times and `dropped_lately` start anew.
  ScanReport take();

 private:
  using Clock = std::chrono::steady_clock;

  mutable std::mutex mutex_;
  ScanReport report_;
  std::size_t timed_ = 0;  ///< scans since the last report
  double total_ms_ = 0.0;
  std::optional<Clock::time_point> last_received_;
};

}  // namespace kestrel
