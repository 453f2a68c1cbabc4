// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/stats.h"

namespace kestrel {

/// A self-contained HTML page: the map with the trajectory (zoom and pan), charts of match quality,
/// overlap, constraint, time per scan and speed, the reasons of the states, statistics and
/// parameters. Measured times and memory are omitted if
/// `info.timing` is false.
std::string reportHtml(const OfflineRun& run, const RunInfo& info);

}  // namespace kestrel
