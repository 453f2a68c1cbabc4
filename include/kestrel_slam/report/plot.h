// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace kestrel {

/// One set of data in a chart, in the units of its axes.
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
  bool equal_axes = false;  ///< a meter is as long in x as in y
  bool from_zero = false;   ///< y = 0 is always in sight
  bool log_y = false;       ///< y by powers of ten; what is not positive is left out
  double height = 1.0;      ///< share of the picture, relative to the other panels
};

/// Draws the panels one below the other into a PNG. Throws std::runtime_error that names the file
/// where it cannot be written.
void writePlot(const std::string& path, const std::vector<PlotPanel>& panels);

}  // namespace kestrel
