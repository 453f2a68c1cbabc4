// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "kestrel_slam/ros/common/waiting_time.h"
#include "kestrel_slam/sensor/projection.h"

namespace kestrel {

/// Counts of used and dropped sweeps of all lasers. Not thread-safe.
struct ProjectorStatistics {
  std::size_t received = 0;
  std::size_t projected = 0;
  std::size_t projected_filtered = 0;          ///< with the attitude of a pose filter
  std::size_t projected_level = 0;             ///< of these, assumed to be level
  std::map<std::string, std::size_t> dropped;  ///< by reason
  std::size_t dropped_lately = 0;              ///< since the last report
  std::string warning;                         ///< about the newest projected scan, or empty
  std::string last_drop;                       ///< reason and sentence of the newest one
  BeamCounts beams;                            ///< of the newest projected sweep
  WaitingTime since_received;

  void drop(const std::string& reason, const std::string& sentence) {
    ++dropped[reason];
    ++dropped_lately;
    last_drop = reason + (sentence.empty() ? "" : ": " + sentence);
  }
};

}  // namespace kestrel
