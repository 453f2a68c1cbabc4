// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/experiments/matcher_comparison.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/offline/stats.h"
#include "kestrel_slam/report/plot.h"

namespace kestrel {
namespace {

constexpr double kMapShare = 2.2, kErrorShare = 1.4;  // relative heights of the panels
/// Number of time intervals of a curve. Each point is the mean of one interval.
constexpr std::size_t kIntervals = 80;

std::string format(const char* format, double value) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string row(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

/// Errors of the relations, each at its later stamp, because the error is complete at that time.
std::vector<PoseError> relationErrors(const MethodRun& method,
                                      const std::vector<Relation>& relations) {
  RelationEvaluation evaluation = evaluateRelations(method.run.trajectory, relations);
  for (std::size_t i = 0; i < evaluation.errors.size(); ++i) {
    evaluation.errors[i].stamp = evaluation.end_stamps[i];
  }
  return std::move(evaluation.errors);
}

/// Distances between poses of equal index. All runs use the same scans, but a run that was stopped
/// has fewer.
std::vector<PoseError> distances(const Trajectory& from, const Trajectory& trajectory) {
  std::vector<PoseError> errors;
  for (std::size_t i = 0; i < std::min(from.size(), trajectory.size()); ++i) {
    const Pose2 difference = from[i].pose.inverse() * trajectory[i].pose;
    errors.push_back({from[i].stamp, difference.distance(), radToDeg(std::abs(difference.yaw))});
  }
  return errors;
}

const MatcherComparison::Errors* errorsOf(const MatcherComparison& comparison,
                                          const std::string& method) {
  for (const MatcherComparison::Errors& entry : comparison.errors) {
    if (entry.method == method) return &entry;
  }
  return nullptr;
}

std::vector<std::string> errorCells(const MatcherComparison::Errors* entry) {
  if (entry == nullptr) return {"", "", "", ""};
  const ErrorStatistics &t = entry->statistics.translation_m, &r = entry->statistics.rotation_deg;
  return {format("%.4f", t.mean), format("%.2f", t.max), format("%.3f", r.mean),
          format("%.1f", r.max)};
}

double meanIterations(const OfflineRun& run) {
  double sum = 0.0;
  for (const ScanRecord& scan : run.scans) sum += scan.iterations;
  return run.scans.empty() ? 0.0 : sum / static_cast<double>(run.scans.size());
}

/// Means over equal time intervals; x is the middle of the interval, in s since `start`.
std::vector<Eigen::Vector2d> curveOf(const std::vector<PoseError>& errors, double start, double end,
                                     double PoseError::*component) {
  std::array<double, kIntervals> sums{}, counts{};
  const double stretch = std::max(end - start, 1e-9) / static_cast<double>(kIntervals);
  for (const PoseError& error : errors) {
    const double place = std::clamp((error.stamp - start) / stretch, 0.0, kIntervals - 1.0);
    sums[static_cast<std::size_t>(place)] += error.*component;
    counts[static_cast<std::size_t>(place)] += 1.0;
  }
  std::vector<Eigen::Vector2d> curve;
  for (std::size_t i = 0; i < kIntervals; ++i) {
    if (counts[i] == 0.0) continue;
    curve.emplace_back((static_cast<double>(i) + 0.5) * stretch, sums[i] / counts[i]);
  }
  return curve;
}

PlotPanel trajectoryPanel(const std::vector<MethodRun>& runs) {
  PlotPanel panel;
  panel.title = "Trajectories";
  panel.x_label = "x, m";
  panel.y_label = "y, m";
  panel.equal_axes = true;
  panel.height = kMapShare;
  for (const MethodRun& method : runs) {
    panel.series.push_back({method.method, {}, PlotSeries::Style::kLine});
    for (const StampedPose& entry : method.run.trajectory) {
      panel.series.back().points.push_back(entry.pose.translation());
    }
  }
  return panel;
}

}  // namespace

MatcherComparison compareRuns(const std::vector<MethodRun>& runs,
                              const std::optional<std::vector<Relation>>& relations,
                              const std::string& reference) {
  MatcherComparison comparison;
  const auto is_reference = [&](const MethodRun& run) { return run.method == reference; };
  auto from = std::find_if(runs.begin(), runs.end(), is_reference);
  if (from == runs.end()) from = runs.begin();
  if (!relations && from != runs.end()) comparison.reference = from->method;
  for (const MethodRun& method : runs) {
    if (method.method == comparison.reference) continue;
    std::vector<PoseError> errors = relations
                                        ? relationErrors(method, *relations)
                                        : distances(from->run.trajectory, method.run.trajectory);
    if (errors.empty()) throw std::runtime_error("no relation has both stamps in the run");
    const PoseErrorStatistics statistics = statisticsOf(errors);
    comparison.errors.push_back({method.method, std::move(errors), statistics});
  }
  return comparison;
}

std::string comparisonTable(const std::vector<MethodRun>& runs, const MatcherComparison& comparison,
                            bool timing) {
  const std::string what =
      comparison.reference.empty() ? "error" : "distance from " + comparison.reference;
  std::vector<std::string> cells = {"matcher", "scans",
                                    "lost",    what + ", m (mean)",
                                    "max",     what + ", deg (mean)",
                                    "max",     "iterations (mean)",
                                    "searched"};
  if (timing) cells.insert(cells.end(), {"ms (mean)", "p99"});
  std::string table = row(cells);
  table += "|" + std::string(1, ' ') + "---";
  for (std::size_t i = 1; i < cells.size(); ++i) table += " | ---:";
  table += " |\n";
  for (const MethodRun& method : runs) {
    const MatchSummary summary = summarize(method.run.scans);
    cells = {method.method, std::to_string(method.run.scans.size()), std::to_string(summary.lost)};
    for (const std::string& cell : errorCells(errorsOf(comparison, method.method))) {
      cells.push_back(cell);
    }
    cells.push_back(format("%.1f", meanIterations(method.run)));
    cells.push_back(std::to_string(summary.searched));
    if (timing) {
      const Distribution ms = scanTimes(method.run);
      cells.push_back(format("%.2f", ms.mean));
      cells.push_back(format("%.2f", ms.p99));
    }
    table += row(cells);
  }
  return table;
}

void plotComparison(const std::string& path, const std::vector<MethodRun>& runs,
                    const MatcherComparison& comparison) {
  const std::string what = comparison.reference.empty() ? "Error of the relations"
                                                        : "Distance from " + comparison.reference;
  const std::string label = comparison.reference.empty() ? "error" : "distance";
  PlotPanel translation{what, "time, s", label + ", m", {}};
  PlotPanel rotation{what + ", rotation", "time, s", label + ", deg", {}};
  translation.log_y = rotation.log_y = true;
  translation.height = rotation.height = kErrorShare;
  const Trajectory& longest = runs.front().run.trajectory;
  for (const MethodRun& method : runs) {
    const MatcherComparison::Errors* entry = errorsOf(comparison, method.method);
    // The reference gets an empty series, so that each method has the same color in all panels.
    PlotSeries t{entry == nullptr ? "" : method.method, {}}, r = t;
    if (entry != nullptr) {
      const double start = longest.front().stamp, end = longest.back().stamp;
      t.points = curveOf(entry->errors, start, end, &PoseError::translation_m);
      r.points = curveOf(entry->errors, start, end, &PoseError::rotation_deg);
    }
    translation.series.push_back(std::move(t));
    rotation.series.push_back(std::move(r));
  }
  writePlot(path, {trajectoryPanel(runs), translation, rotation});
}

}  // namespace kestrel
