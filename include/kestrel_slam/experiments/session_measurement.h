// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/pipeline/slam_config.h"
#include "kestrel_slam/session/session.h"

namespace kestrel {

/// A session after one of several flights.
struct FlightOfSession {
  std::size_t keyframes = 0;
  bool joined = true;      ///< with the flights before
  double megabytes = 0.0;  ///< of the file
  double drift_m = 0.0;    ///< largest motion of a keyframe of the first flight since the first day
  double save_s = 0.0;     ///< encoded and written
  double load_s = 0.0;     ///< read, with graph and map
};

/// Maps the same recording `flights` times, each time as a continuation that starts where the first
/// flight began. A tenth of the beams is left out, always another one. The session is left in
/// `file`.
std::vector<FlightOfSession> measureFlights(const std::string& recording, const SlamConfig& config,
                                            int flights, const std::string& file);

/// Saves a session again and again in a process that is killed at random times. Returns a line for
/// every time that the file was not whole, or that another file was left beside it. `folder` must
/// be empty.
std::vector<std::string> measureKills(const std::string& folder, const Session& session, int kills);

struct DamageCounts {
  std::size_t tried = 0, refused = 0;
  std::size_t same = 0;       ///< the content came out as it was
  std::size_t different = 0;  ///< another content came out silently
};

/// Changes single bytes of a session file (`flips` of them, evenly), and cuts it off at every chunk
/// and one byte before and after.
DamageCounts measureDamage(const std::string& bytes, std::size_t flips);

}  // namespace kestrel
