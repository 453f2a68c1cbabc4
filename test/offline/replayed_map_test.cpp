// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/replayed_map.h"

#include <gtest/gtest.h>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/simulated_recording.h"

namespace kestrel {
namespace {

/// A tilting flight with IMU, so that some insertions are new views.
OfflineRun fly(const SlamConfig& config, ReplayedMap& map, bool use_filter) {
  SimulatedRecording flight(place("laboratory"), quadrotorWith("utm30lx"), 1);
  RunOptions options;
  options.max_scans = 500;
  options.use_filter = use_filter;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    map.add(scan, result);
  };
  return runOffline(flight, config, options);
}

TEST(ReplayedMap, IsTheMapOfTheMapper) {
  for (const bool use_filter : {false, true}) {
    SlamConfig config;
    config.mapper.window.enabled = false;
    ReplayedMap map(config.mapper);
    const OfflineRun run = fly(config, map, use_filter);
    const MapSnapshot replayed = map.map().grid().snapshot();
    ASSERT_EQ(run.scans.size(), 500U);
    EXPECT_EQ(replayed.width, run.map.width);
    EXPECT_EQ(replayed.height, run.map.height);
    EXPECT_EQ(replayed.cells, run.map.cells);
  }
}

TEST(ReplayedMap, IsTheSameForAStitchingMatcher) {
  SlamConfig config;
  config.mapper.window.enabled = false;
  config.mapper.matcher.method = "icp";
  config.mapper.matcher.icp.stitching = true;
  ReplayedMap map(config.mapper);
  const OfflineRun run = fly(config, map, false);
  EXPECT_EQ(map.map().grid().snapshot().cells, run.map.cells);
}

}  // namespace
}  // namespace kestrel
