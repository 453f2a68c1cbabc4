// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kestrel_slam/report/plot.h"

namespace kestrel {

struct Range {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();

  void include(double value) {
    min = std::min(min, value);
    max = std::max(max, value);
  }
  double size() const { return max - min; }
  void grow(double by) {
    min -= by / 2.0;
    max += by / 2.0;
  }
};

/// The position of a panel in the image and the data range that it shows.
struct Frame {
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0;
  Range x, y;
  bool log_y = false;  ///< `y` is the range of the logarithms

  /// Not finite if the value cannot be shown.
  double onScale(double value) const { return log_y ? std::log10(value) : value; }
  double px(double value) const { return left + (value - x.min) / x.size() * width; }
  double py(double value) const {
    return top + height - (onScale(value) - y.min) / y.size() * height;
  }
};

/// Makes the frame show all cells of a heat map.
void includeHeat(const PlotHeat& heat, Frame& frame);

/// Draws the cells and a scale of the colors.
void drawHeat(cairo_t* cr, const PlotHeat& heat, const Frame& frame);

}  // namespace kestrel
