// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>

#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// What the panel of rviz shows, from the diagnostics of the mapper.
struct MapperSummary {
  std::string node;     ///< that the diagnostics come from, for example "/mapper"
  std::string state;    ///< ok, degraded, lost, stale, paused; "" before the first scan
  std::string reason;   ///< of the state
  std::string problem;  ///< of the scans or of the map, for the user; "" if there is none
  std::string map;      ///< size and memory
  std::string mode;     ///< mapping, localization; "" if the mapper has no modes
  std::string loops;    ///< "3 closed, 1 refused"; "" without a pose graph
  std::string tracks;   ///< number of moving objects; "" without a tracker
  double received = 0.0;
  double used = 0.0;
  double ms = 0.0;                                           ///< per scan, mean
  std::vector<std::pair<std::string, std::string>> dropped;  ///< reason and number
};

/// Takes over what the message says about the mapper `node`; with an empty `node`, about any
/// mapper. Returns whether it says anything.
bool takeOver(const diagnostic_msgs::DiagnosticArray& message, const std::string& node,
              MapperSummary& summary);

}  // namespace kestrel
