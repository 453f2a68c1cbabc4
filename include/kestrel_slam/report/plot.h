// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace kestrel {

/// One data series of a chart, in the units of its axes.
struct PlotSeries {
  enum class Style { kLine, kDots, kSegments };  ///< kSegments: a line for every two points

  std::string name;
  std::vector<Eigen::Vector2d> points;
  Style style = Style::kLine;
  std::optional<std::size_t> color =
      std::nullopt;  ///< number in the palette; by default that of the series
};

/// Number of black in the palette, for lines on a heat map.
constexpr std::size_t kPlotBlack = 8;

/// An image of values from 0 to 1, drawn below the series.
struct PlotHeat {
  int columns = 0, rows = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();  ///< center of the first cell
  double step = 0.0;                                ///< between two cells, in x and y
  std::vector<float> values;                        ///< row by row
};

/// One chart with axes, ticks and a legend.
struct PlotPanel {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_axes = false;     ///< same scale in x and y
  bool from_zero = false;      ///< the y axis includes 0
  bool log_y = false;          ///< logarithmic y axis; values that are not positive are omitted
  double height = 1.0;         ///< relative to the other panels
  PlotHeat heat = PlotHeat();  ///< no columns: none
};

/// Draws the panels, one below the other, into the PNG `path` and into an SVG of the same name.
/// Throws std::runtime_error with the name of the file if it cannot be written.
void writePlot(const std::string& path, const std::vector<PlotPanel>& panels);

}  // namespace kestrel
