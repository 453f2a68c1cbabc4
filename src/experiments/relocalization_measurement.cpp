// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/relocalization_measurement.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "kestrel_slam/experiments/processor_time.h"
#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/graph/localizer.h"
#include "kestrel_slam/graph/place_finder.h"
#include "kestrel_slam/map/map_io.h"
#include "kestrel_slam/map/picture_map.h"
#include "kestrel_slam/matching/fit.h"
#include "kestrel_slam/offline/offline_run.h"
#include "kestrel_slam/recording/recording.h"

namespace kestrel {
namespace {

/// Goals for a right answer.
constexpr double kRightM = kWrongPoseM, kRightDeg = 5.0;
/// The path is measured in steps of this length, m.
constexpr double kPathStepM = 0.1;
constexpr std::int64_t kWorkStep = 50'000'000;
/// Of a kidnapping: scans before it, and limits of the time between two scans, s.
constexpr std::size_t kFollowedScans = 20;
constexpr double kLeastStepS = 0.01, kMostStepS = 0.5, kCoveredStepS = 0.1;

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
    : scans_(scans),
      first_(first),
      last_(last),
      map_(mapOfScans(scans, first, last, config_.grid)),
      global_(map_) {}

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

bool RelocalizationMap::isKnown(const PlacedScan& scan) const {
  return fitOf(map_, hitsOf(scan.scan), scan.pose, config_.matcher.score_scale_m).known >= kInMap;
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
    finder.add(scans[i].scan, mapper.process(scans[i].scan).pose);
    const double start = processorSeconds();
    if (finder.advance(RelocalizationConfig().most_work)) {
      trial.seconds.push_back(processorSeconds() - start);
      trial.answer = finder.answer();
    }
    compare(scans[i], trial);
    if (i == first) begins_in_map = trial.in_map;
    if (trial.isFound()) break;
    if (!last) last = scans[i].pose;
    if (last->between(scans[i].pose).distance() < kPathStepM) continue;
    trial.travel_m += last->between(scans[i].pose).distance();
    last = scans[i].pose;
  }
  // The recording may end before.
  trial.in_map &= begins_in_map && (trial.isFound() || trial.travel_m > travel_m);
  trial.memory_bytes = finder.memoryBytes();
  return trial;
}

Submap RelocalizationMap::mapToLocalizeIn(bool picture) const {
  if (!picture) return mapOfScans(scans_, first_, last_, config_.grid);
  std::string folder = (std::filesystem::temp_directory_path() / "kestrel_map_XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) throw std::runtime_error("cannot create " + folder);
  writeMap(folder + "/map", map_.grid().snapshot());
  Submap result = submapOf(readMap(folder + "/map.yaml"), config_.grid);
  std::filesystem::remove_all(folder);
  return result;
}

LocalizationTrial RelocalizationMap::localize(const std::vector<PlacedScan>& scans,
                                              std::size_t first, std::size_t last,
                                              bool picture) const {
  LocalizationTrial trial;
  trial.scans = last - first;
  Localizer localizer(config_, mapToLocalizeIn(picture));
  bool found = false;
  double sum = 0.0;
  const double start = processorSeconds();
  for (std::size_t i = first; i < last; ++i) {
    const MapperResult result = localizer.process(scans[i].scan);
    if (localizer.isLost()) {
      trial.lost += found ? 1 : 0;
      continue;
    }
    found = true;
    trial.trajectory.push_back({scans[i].scan.stamp, result.pose});
    const double error = scans[i].pose.between(result.pose).distance();
    trial.wrong += error > kRightM ? 1 : 0;
    sum += error;
    trial.max_m = std::max(trial.max_m, error);
  }
  trial.seconds = processorSeconds() - start;
  trial.mean_m = sum / static_cast<double>(std::max<std::size_t>(1, trial.trajectory.size()));
  Mapper mapper(config_);
  const double begin = processorSeconds();
  for (std::size_t i = first; i < last; ++i) mapper.process(scans[i].scan);
  trial.mapping_seconds = processorSeconds() - begin;
  return trial;
}

KidnapTrial RelocalizationMap::kidnap(const std::vector<PlacedScan>& scans, std::size_t from,
                                      std::size_t to, double covered_s, double travel_m) const {
  KidnapTrial trial;
  Localizer localizer(config_, mapOfScans(scans_, first_, last_, config_.grid));
  localizer.setPose(scans[from].pose);
  double time = 0.0;
  const auto process = [&](PlanarScan scan, double step) {
    scan.time = time += step;
    return localizer.process(scan);
  };
  const auto stepTo = [&](std::size_t i) {
    return std::clamp(scans[i].scan.time - scans[i - 1].scan.time, kLeastStepS, kMostStepS);
  };
  for (std::size_t i = from; i < from + kFollowedScans && i < scans.size(); ++i)
    process(scans[i].scan, stepTo(i));
  for (double covered = 0.0; covered < covered_s; covered += kCoveredStepS) {
    PlanarScan nothing = scans[from].scan;
    nothing.rays.clear();
    process(nothing, kCoveredStepS);
  }
  const double uncovered = time;
  for (std::size_t i = to; i < scans.size() && trial.travel_m <= travel_m; ++i) {
    const MapperResult result = process(scans[i].scan, stepTo(i));
    if (i > to) trial.travel_m += scans[i - 1].pose.between(scans[i].pose).distance();
    const double error = scans[i].pose.between(result.pose).distance();
    if (trial.add(time - uncovered, localizer.isLost(), error)) break;
  }
  return trial;
}

GapTrial RelocalizationMap::followOverGap(const std::vector<PlacedScan>& scans, std::size_t from,
                                          double gap_s) const {
  constexpr double kAfterS = 3.0;
  GapTrial trial;
  Localizer localizer(config_, mapOfScans(scans_, first_, last_, config_.grid));
  localizer.setPose(scans[from].pose);
  std::size_t i = from;
  for (; i < from + kFollowedScans && i < scans.size(); ++i) localizer.process(scans[i].scan);
  const double begin = scans[i - 1].scan.time + gap_s;
  for (; i < scans.size() && scans[i].scan.time < begin + kAfterS; ++i) {
    if (scans[i].scan.time < begin) continue;
    const MapperResult result = localizer.process(scans[i].scan);
    ++trial.scans;
    if (result.state == MatchState::kLost) {
      ++trial.lost;
    } else if (scans[i].pose.between(result.pose).distance() > kRightM) {
      ++trial.wrong;
    }
  }
  return trial;
}

}  // namespace kestrel
