// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "kestrel_slam/offline/offline_run.h"

namespace kestrel {

std::size_t OfflineRun::droppedCount() const {
  std::size_t count = 0;
  for (const auto& entry : dropped) count += entry.second;
  return count;
}

std::string OfflineRun::mainProblem() const {
  if (dropped.empty()) return warnings.empty() ? "it has no scans" : warnings.front();
  const auto is_rarer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto& [reason, count] = *std::max_element(dropped.begin(), dropped.end(), is_rarer);
  const std::string start =
      std::to_string(count) + " of " + std::to_string(droppedCount()) + " dropped (" + reason + ")";
  const auto message = drop_messages.find(reason);
  if (message != drop_messages.end()) return start + ": " + message->second;
  // The recording itself skipped them, and its warnings say why.
  for (const std::string& warning : warnings) {
    if (warning.find(reason) != std::string::npos) return start + ": " + warning;
  }
  return start + (warnings.empty() ? "" : ": " + warnings.front());
}

double OfflineRun::speedFactor() const {
  return processing_s > 0.0 ? duration_s / processing_s : 0.0;
}

}  // namespace kestrel
