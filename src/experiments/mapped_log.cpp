// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/mapped_log.h"

#include <memory>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

MappedLog mapLog(const std::string& path, double resolution_m) {
  const SlamConfig config;
  OccupancyGridConfig grid = config.mapper.grid;
  grid.resolution_m = resolution_m;
  const std::unique_ptr<Recording> recording = openRecording(path);
  MappedLog log{Submap(grid), {}};
  RunOptions options;
  options.observer = [&log](const PlanarScan& scan, const MapperResult& result) {
    if (result.inserted) log.map.insert(scan, result.pose);
    log.scans.push_back({hitsOf(scan), result.pose});
  };
  runOffline(*recording, config, options);
  return log;
}

}  // namespace kestrel
