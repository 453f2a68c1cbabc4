// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/mapped_log.h"

#include <memory>

#include "kestrel_slam/mapping/mapper.h"
#include "kestrel_slam/parameters/parameters.h"
#include "kestrel_slam/recording/recording.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {

MappedLog mapLog(const std::string& path, double resolution_m) {
  const SlamConfig config;
  OccupancyGridConfig grid = config.mapper.grid;
  grid.resolution_m = resolution_m;
  const std::unique_ptr<Recording> recording = openRecording(path);
  ScanProjector projector(config.projector);
  Mapper mapper(config.mapper);
  MappedLog log{Submap(grid), {}};
  RecordedScan recorded;
  while (recording->next(recorded)) {
    Projection projection = projector.project(recorded.scan, recorded.base_T_laser);
    if (projection.error != ScanError::kNone) continue;
    projection.scan.time = recorded.time;
    const MapperResult result = mapper.process(projection.scan);
    if (result.inserted) log.map.insert(projection.scan, result.pose);
    MappedScan mapped{{}, result.pose};
    for (const PlanarRay& ray : projection.scan.rays) {
      if (ray.hit) mapped.points.push_back(ray.end);
    }
    log.scans.push_back(std::move(mapped));
  }
  return log;
}

}  // namespace kestrel
