// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/evaluation_plot.h"

#include <cstdio>
#include <vector>

#include "kestrel_slam/report/plot.h"

namespace kestrel {
namespace {

constexpr double kMapShare = 2.5;  // height of the map panel relative to an error panel

std::vector<Eigen::Vector2d> positions(const Trajectory& trajectory) {
  std::vector<Eigen::Vector2d> points;
  for (const StampedPose& entry : trajectory) points.push_back(entry.pose.translation());
  return points;
}

PlotPanel trajectoryPanel(const std::string& name, const Trajectory& trajectory,
                          const std::optional<ReferenceEvaluation>& reference) {
  PlotPanel panel;
  panel.title = "Trajectory of " + name;
  panel.x_label = "x, m";
  panel.y_label = "y, m";
  panel.equal_axes = true;
  panel.height = kMapShare;
  if (reference) panel.series.push_back({"reference", positions(reference->reference)});
  panel.series.push_back({"estimate", positions(reference ? reference->aligned : trajectory)});
  return panel;
}

std::string rmseText(const ErrorStatistics& statistics, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, ": rmse %.4g %s, max %.4g %s", statistics.rmse, unit,
                statistics.max, unit);
  return text;
}

/// Adds two panels with the errors over the time since `start`: one in meters, one in degrees.
void addErrorPanels(const std::string& title, const std::vector<PoseError>& errors,
                    const PoseErrorStatistics& statistics, double start, PlotSeries::Style style,
                    std::vector<PlotPanel>& panels) {
  PlotSeries translation{"", {}, style}, rotation{"", {}, style};
  for (const PoseError& error : errors) {
    translation.points.emplace_back(error.stamp - start, error.translation_m);
    rotation.points.emplace_back(error.stamp - start, error.rotation_deg);
  }
  panels.push_back({title + rmseText(statistics.translation_m, "m"),
                    "time, s",
                    "error, m",
                    {translation},
                    false,
                    true});
  panels.push_back({title + rmseText(statistics.rotation_deg, "deg"),
                    "time, s",
                    "error, deg",
                    {rotation},
                    false,
                    true});
}

}  // namespace

void plotEvaluation(const std::string& path, const std::string& name, const Trajectory& trajectory,
                    const std::optional<RelationEvaluation>& relations,
                    const std::optional<ReferenceEvaluation>& reference) {
  const double start = trajectory.empty() ? 0.0 : trajectory.front().stamp;
  std::vector<PlotPanel> panels = {trajectoryPanel(name, trajectory, reference)};
  if (relations) {
    addErrorPanels("Error of each relation, at its first stamp", relations->errors, relations->all,
                   start, PlotSeries::Style::kDots, panels);
  }
  if (reference) {
    addErrorPanels("Error of each pose after alignment", reference->ate, reference->ate_statistics,
                   start, PlotSeries::Style::kLine, panels);
  }
  writePlot(path, panels);
}

}  // namespace kestrel
