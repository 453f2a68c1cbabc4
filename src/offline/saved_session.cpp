// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/saved_session.h"

#include "kestrel_slam/graph/repeated_keyframes.h"
#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/offline/version.h"
#include "kestrel_slam/parameters/parameters_yaml.h"
#include "kestrel_slam/session/graph_session.h"

namespace kestrel {

Session savedSession(const SubmapGraph& graph, const SlamConfig& config, const Session* before,
                     const OfflineRun& run) {
  const OccupancyGridConfig& grid = config.mapper.grid;
  Session session =
      sessionOf(withoutRepeated(graph.record(), graph.loadedCount(), grid), grid.resolution_m);
  session.written_by = std::string("kestrel_slam ") + kVersion;
  session.parameters = parametersYaml(config);
  if (before != nullptr) session.statistics = before->statistics;
  addStatistic(session, "flights", 1.0);
  addStatistic(session, "scans", static_cast<double>(run.scans.size()));
  addStatistic(session, "distance_m", run.distance_m);
  addStatistic(session, "duration_s", run.duration_s);
  if (!run.trajectory.empty()) session.end = run.trajectory.back().pose;
  return session;
}

}  // namespace kestrel
