// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kestrel_slam/recording/recording.h"

namespace kestrel {

/// The scans that are left.
inline std::vector<RecordedScan> readAll(Recording& recording) {
  std::vector<RecordedScan> scans;
  for (RecordedScan scan; recording.next(scan);) scans.push_back(scan);
  return scans;
}

}  // namespace kestrel
