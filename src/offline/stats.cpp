// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/stats.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kestrel_slam/offline/provenance.h"
#include "kestrel_slam/session/version.h"

namespace kestrel {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kBytesPerMegabyte = 1024.0 * 1024.0;
constexpr int kCoarse = 1, kFine = 3, kFinest = 6;  // decimals

double shareOf(std::size_t part, std::size_t all) {
  if (all == 0) return 0.0;
  return rounded(static_cast<double>(part) / static_cast<double>(all), kFinest);
}

Json scansOf(const OfflineRun& run, const MatchSummary& match) {
  return {{"read", run.scans.size() + run.droppedCount() + run.left_out},
          {"processed", run.scans.size()},
          {"dropped", Json(run.dropped)},
          {"left_out", run.left_out},
          {"inserted", match.inserted},
          {"searched", match.searched},
          {"lost", match.lost}};
}

Json matchOf(const MatchSummary& match, std::size_t scans) {
  return {{"quality_mean", rounded(match.mean_score, kFinest)},
          {"quality_min", rounded(match.min_score, kFinest)},
          {"share_ok", shareOf(match.ok, scans)},
          {"share_degraded", shareOf(match.degraded, scans)},
          {"share_lost", shareOf(match.lost, scans)}};
}

Json filterOf(const OfflineRun& run) {
  if (!run.filter) return "none";
  const SensorCounts& poses = run.filter->of(FilterSensor::kPose);
  return {{"health", toString(run.filter->health)},
          {"states", run.filter->imu.accepted},
          {"poses_used", poses.accepted},
          {"poses_refused", poses.received - poses.accepted},
          {"resets", Json(run.filter->resets)}};
}

Json mapOf(const OfflineRun& run) {
  const MapSnapshot& map = run.map;
  return {
      {"resolution_m", map.resolution_m},
      {"width_cells", map.width},
      {"height_cells", map.height},
      {"width_m", rounded(map.width * map.resolution_m, kFine)},
      {"height_m", rounded(map.height * map.resolution_m, kFine)},
      {"known_area_m2", rounded(knownArea(map), kCoarse)},
      {"memory_mb", rounded(static_cast<double>(run.map_memory_bytes) / kBytesPerMegabyte, kFine)}};
}

/// Without a pose graph: "none".
Json graphOf(const OfflineRun& run) {
  if (!run.graph) return "none";
  Json loops = Json::object();
  for (const auto& [what, count] : run.graph->counts()) loops[what] = count;
  double correction = 0.0;
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    const Pose2& before = run.graph->before[i].pose;
    correction = std::max(correction, before.between(run.trajectory[i].pose).distance());
  }
  return {{"keyframes", run.graph->stamps.size()},
          {"submaps", run.graph->submaps},
          {"loops", loops},
          {"largest_correction_m", rounded(correction, kFine)},
          {"memory_mb",
           rounded(static_cast<double>(run.graph->memory_bytes) / kBytesPerMegabyte, kFine)}};
}

Json stagesOf(const OfflineRun& run) {
  Json stages = Json::object();
  for (std::size_t i = 0; i < kPipelineStages; ++i) {
    const auto stage = static_cast<PipelineStage>(i);
    const Distribution ms = stageTimes(run, stage);
    stages[toString(stage)] = {{"mean", rounded(ms.mean, kFine)}, {"p99", rounded(ms.p99, kFine)}};
  }
  return stages;
}

Json timingOf(const OfflineRun& run) {
  const Distribution scan_ms = scanTimes(run);
  // Side by side they tell whether the time grows with the map.
  const Distribution first = scanTimes(run, 0.0, 0.25), last = scanTimes(run, 0.75, 1.0);
  return {{"ms_per_scan",
           {{"mean", rounded(scan_ms.mean, kFine)},
            {"median", rounded(scan_ms.median, kFine)},
            {"p99", rounded(scan_ms.p99, kFine)},
            {"max", rounded(scan_ms.max, kFine)},
            {"median_first_quarter", rounded(first.median, kFine)},
            {"median_last_quarter", rounded(last.median, kFine)}}},
          {"stages_ms", stagesOf(run)},
          {"processing_s", rounded(run.processing_s, kFine)},
          {"speed_factor", rounded(run.speedFactor(), kCoarse)},
          {"peak_memory_mb", rounded(run.peak_memory_mb, kCoarse)}};
}

/// Converts a parameter value to JSON and keeps its type if JSON supports it.
Json valueOf(const Parameter& parameter) {
  return std::visit([](const auto* value) { return Json(*value); }, parameter.value);
}

Json parametersJson(SlamConfig config) {
  Json parameters = Json::object();
  for (const Parameter& parameter : parametersOf(config)) {
    parameters[parameter.name] = valueOf(parameter);
  }
  return parameters;
}

}  // namespace

Distribution distributionOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  constexpr double kPercentile = 0.99;
  const double rank = std::ceil(kPercentile * static_cast<double>(n));  // nearest rank, from 1
  return {sum / static_cast<double>(n), (values[(n - 1) / 2] + values[n / 2]) / 2.0,
          values[static_cast<std::size_t>(rank) - 1], values.back()};
}

Distribution scanTimes(const OfflineRun& run, double from, double to) {
  const auto count = static_cast<double>(run.scans.size());
  std::vector<double> ms;
  for (auto i = static_cast<std::size_t>(from * count); i < static_cast<std::size_t>(to * count);
       ++i) {
    ms.push_back(run.scans[i].ms);
  }
  return distributionOf(std::move(ms));
}

Distribution stageTimes(const OfflineRun& run, PipelineStage stage) {
  std::vector<double> ms;
  for (const ScanRecord& scan : run.scans)
    ms.push_back(scan.stage_ms[static_cast<std::size_t>(stage)]);
  return distributionOf(std::move(ms));
}

MatchSummary summarize(const std::vector<ScanRecord>& scans) {
  MatchSummary summary;
  if (scans.empty()) return summary;
  summary.min_score = scans.front().score;
  for (const ScanRecord& scan : scans) {
    summary.ok += scan.state == MatchState::kOk ? 1U : 0U;
    summary.degraded += scan.state == MatchState::kDegraded ? 1U : 0U;
    summary.lost += scan.state == MatchState::kLost ? 1U : 0U;
    summary.inserted += scan.inserted ? 1U : 0U;
    summary.searched += scan.searched ? 1U : 0U;
    summary.mean_score += scan.score / static_cast<double>(scans.size());
    summary.min_score = std::min(summary.min_score, scan.score);
  }
  return summary;
}

double knownArea(const MapSnapshot& map) {
  const auto known = std::count_if(map.cells.begin(), map.cells.end(),
                                   [](std::int8_t cell) { return cell != MapSnapshot::kUnknown; });
  return static_cast<double>(known) * map.resolution_m * map.resolution_m;
}

double rounded(double value, int decimals) {
  const double factor = std::pow(10.0, decimals);
  const double result = std::round(value * factor) / factor;
  return result == 0.0 ? 0.0 : result;  // no "-0.0"
}

nlohmann::ordered_json statsOf(const OfflineRun& run, const RunInfo& info) {
  const MatchSummary match = summarize(run.scans);
  const Json parameters = parametersJson(info.config);
  Json options = Json::object();
  for (const auto& [name, value] : info.options) options[name] = value;
  Json stats = {
      {"version", kVersion},
      {"commit", builtCommit()},
      {"recording",
       {{"name", info.recording}, {"description", info.description}, {"hash", info.hash}}},
      {"parameters_hash", hashOfText(parameters.dump() + options.dump())},
      {"odometry", info.odometry ? "use" : "none"},
      {"filter", filterOf(run)},
      {"scans", scansOf(run, match)},
      {"match", matchOf(match, run.scans.size())},
      {"distance_m", rounded(run.distance_m, kFine)},
      {"duration_s", rounded(run.duration_s, kFine)},
      {"map", mapOf(run)},
      {"graph", graphOf(run)},
      {"options", options},
      {"parameters", parameters},
      {"warnings", run.warnings}};
  if (info.timing) stats["timing"] = timingOf(run);
  return stats;
}

}  // namespace kestrel
