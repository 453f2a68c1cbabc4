// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/evaluation_plot.h"

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

PlotPanel trajectoryPanel(const Trajectory& trajectory,
                          const std::optional<ReferenceEvaluation>& reference) {
  PlotPanel panel;
  panel.title = "Trajectory";
  panel.x_label = "x, m";
  panel.y_label = "y, m";
  panel.equal_axes = true;
  panel.height = kMapShare;
  if (reference) panel.series.push_back({"reference", positions(reference->reference)});
  panel.series.push_back({"estimate", positions(reference ? reference->aligned : trajectory)});
  return panel;
}

/// Adds two panels with the errors over the time since `start`: one in meters, one in degrees.
void addErrorPanels(const std::string& title, const std::vector<PoseError>& errors, double start,
                    PlotSeries::Style style, std::vector<PlotPanel>& panels) {
  PlotSeries translation{"", {}, style}, rotation{"", {}, style};
  for (const PoseError& error : errors) {
    translation.points.emplace_back(error.stamp - start, error.translation_m);
    rotation.points.emplace_back(error.stamp - start, error.rotation_deg);
  }
  panels.push_back({title + ": translation", "time, s", "error, m", {translation}, false, true});
  panels.push_back({title + ": rotation", "time, s", "error, deg", {rotation}, false, true});
}

}  // namespace

void plotEvaluation(const std::string& path, const Trajectory& trajectory,
                    const std::optional<RelationEvaluation>& relations,
                    const std::optional<ReferenceEvaluation>& reference) {
  const double start = trajectory.empty() ? 0.0 : trajectory.front().stamp;
  std::vector<PlotPanel> panels = {trajectoryPanel(trajectory, reference)};
  if (relations) {
    addErrorPanels("Error of each relation, at its first stamp", relations->errors, start,
                   PlotSeries::Style::kDots, panels);
  }
  if (reference) {
    addErrorPanels("Error of each pose after alignment", reference->ate, start,
                   PlotSeries::Style::kLine, panels);
  }
  writePlot(path, panels);
}

}  // namespace kestrel
