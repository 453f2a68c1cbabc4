// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace kestrel {

/// One data series of a chart, in the units of its axes.
struct PlotSeries {
  enum class Style { kLine, kDots };

  std::string name;
  std::vector<Eigen::Vector2d> points;
  Style style = Style::kLine;
};

/// One chart with axes, ticks and a legend.
struct PlotPanel {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_axes = false;  ///< same scale in x and y
  bool from_zero = false;   ///< the y axis includes 0
  bool log_y = false;       ///< logarithmic y axis; values that are not positive are omitted
  double height = 1.0;      ///< relative to the other panels
};

/// Draws the panels into a PNG, one below the other. Throws std::runtime_error with the name of the
/// file if it cannot be written.
void writePlot(const std::string& path, const std::vector<PlotPanel>& panels);

}  // namespace kestrel
