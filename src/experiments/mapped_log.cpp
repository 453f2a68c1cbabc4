// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/mapped_log.h"

#include <memory>
#include <utility>

#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/offline/replayed_map.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {

MappedLog mapLog(const std::string& path, double resolution_m) {
  SlamConfig config;
  config.mapper.window.enabled = false;  // one map, as ReplayedMap builds it
  const std::unique_ptr<Recording> recording = openRecording(path);
  ReplayedMap map(config.mapper, resolution_m);
  std::vector<MappedScan> scans;
  RunOptions options;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    map.add(scan, result);
    scans.push_back({hitsOf(scan), result.pose});
  };
  runOffline(*recording, config, options);
  return {map.take(), std::move(scans)};
}

}  // namespace kestrel
