// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "kestrel_slam/mapping/mapper.h"

namespace kestrel {

/// Decides when a lost vehicle should begin a new map: what it sees was searched for around the
/// predicted pose for some time, and is not there.
class LostWatch {
 public:
  /// Adds the result of a scan at `time`, s. Returns true when a new map should begin, and counts
  /// from zero again.
  bool add(const MapperResult& result, double time);

 private:
  std::optional<double> since_;  ///< time of the first lost scan
  int scans_ = 0;                ///< lost scans since then that had enough hits
};

}  // namespace kestrel
