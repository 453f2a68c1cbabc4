// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/relocalization_measurement.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/graph/place_finder.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {
namespace {

/// Goals for a right answer.
constexpr double kRightM = 0.5, kRightDeg = 5.0;
/// The path is measured in steps of this length, m.
constexpr double kPathStepM = 0.1;
constexpr std::int64_t kWorkStep = 50'000'000;

double processorSeconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

Submap mapOfScans(const std::vector<PlacedScan>& scans, std::size_t first, std::size_t last,
                  const OccupancyGridConfig& grid) {
  Submap map(grid);
  for (std::size_t i = first; i < last; ++i) {
    if (scans[i].inserted) map.insert(scans[i].scan, scans[i].pose, scans[i].new_view);
  }
  return map;
}

/// A mapper whose poses do not jump if a loop is closed.
MapperConfig localConfig(MapperConfig config) {
  config.window.enabled = true;
  return config;
}

}  // namespace

bool RelocalizationTrial::isRight() const { return error_m < kRightM && error_deg < kRightDeg; }

std::vector<PlacedScan> placeScans(const std::string& path) {
  SlamConfig config;
  config.mapper.window.enabled = true;
  const std::unique_ptr<Recording> recording = openRecording(path);
  std::vector<PlacedScan> scans;
  RunOptions options;
  options.observer = [&](const PlanarScan& scan, const MapperResult& result) {
    scans.push_back({scan, result.pose, result.inserted, result.new_view});
  };
  const OfflineRun run = runOffline(*recording, config, options);
  for (std::size_t i = 0; i < scans.size(); ++i) scans[i].pose = run.trajectory[i].pose;
  return scans;
}

RelocalizationMap::RelocalizationMap(const std::vector<PlacedScan>& scans, std::size_t first,
                                     std::size_t last)
    : map_(mapOfScans(scans, first, last, config_.grid)), global_(map_) {}

void RelocalizationMap::compare(const PlacedScan& scan, RelocalizationTrial& trial) const {
  trial.stamp = scan.scan.stamp;
  const Fit fit = fitOf(map_, hitsOf(scan.scan), scan.pose, config_.matcher.score_scale_m);
  trial.known = fit.known;
  trial.fit = fit.score;
  trial.in_map = fit.known >= kInMap;
  if (trial.answer.hypotheses.empty()) return;
  const Pose2 error = scan.pose.between(trial.answer.pose().mean);
  trial.error_m = error.distance();
  trial.error_deg = radToDeg(std::abs(error.yaw));
}

RelocalizationTrial RelocalizationMap::locate(const PlacedScan& scan) const {
  RelocalizationTrial trial;
  Relocalizer relocalizer(global_, config_.matcher, RelocalizationConfig());
  const double start = processorSeconds();
  relocalizer.begin({{{Pose2(), scan.scan}}});
  while (relocalizer.isSearching()) {
    trial.memory_bytes = std::max(trial.memory_bytes, relocalizer.memoryBytes());
    relocalizer.advance(kWorkStep);
  }
  trial.answer = relocalizer.answer();
  trial.seconds.push_back(processorSeconds() - start);
  compare(scan, trial);
  return trial;
}

RelocalizationTrial RelocalizationMap::follow(const std::vector<PlacedScan>& scans,
                                              std::size_t first, double travel_m) const {
  RelocalizationTrial trial;
  Mapper mapper(localConfig(config_));
  PlaceFinder finder(global_, config_.matcher, RelocalizationConfig());
  bool begins_in_map = false;
  std::optional<Pose2> last;
  for (std::size_t i = first; i < scans.size() && trial.travel_m <= travel_m; ++i) {
    const Pose2 local_T_base = mapper.process(scans[i].scan).pose;
    finder.add(scans[i].scan, local_T_base);
    const double start = processorSeconds();
    if (finder.advance(RelocalizationConfig().most_work)) {
      trial.seconds.push_back(processorSeconds() - start);
      trial.answer = finder.answer();
    }
    compare(scans[i], trial);
    if (i == first) begins_in_map = trial.in_map;
    if (trial.isFound()) break;
    if (!last) last = local_T_base;
    if (last->between(local_T_base).distance() < kPathStepM) continue;
    trial.travel_m += last->between(local_T_base).distance();
    last = local_T_base;
  }
  trial.in_map &= begins_in_map;
  trial.memory_bytes = finder.memoryBytes();
  return trial;
}

}  // namespace kestrel
