// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/stats.h"

namespace kestrel {

/// A page that needs nothing but itself: the map with the trajectory (zoom and pan), the course of
/// match quality, time per scan and speed, the figures and the parameters. Everything measured is
/// left out where `info.timing` is false.
std::string reportHtml(const OfflineRun& run, const RunInfo& info);

}  // namespace kestrel
