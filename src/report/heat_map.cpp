// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "plot_frame.h"

namespace kestrel {
namespace {

/// Colors for 0, 1/3, 2/3 and 1.
constexpr std::array<std::array<double, 3>, 4> kHeatColors = {
    {{1.0, 1.0, 1.0}, {1.0, 0.93, 0.65}, {0.99, 0.70, 0.40}, {0.88, 0.36, 0.27}}};

void setHeatColor(cairo_t* cr, double value) {
  const double place = std::clamp(value, 0.0, 1.0) * (kHeatColors.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(place), kHeatColors.size() - 2);
  const double share = place - static_cast<double>(i);
  const auto mixed = [&](std::size_t k) {
    return (1.0 - share) * kHeatColors[i][k] + share * kHeatColors[i + 1][k];
  };
  cairo_set_source_rgb(cr, mixed(0), mixed(1), mixed(2));
}

void drawScale(cairo_t* cr, const Frame& frame) {
  constexpr int kSteps = 50;
  constexpr double kWidth = 150.0, kHeight = 12.0, kGap = 15.0, kText = 8.0;  // pixels
  const double left = frame.left + frame.width - kWidth - 4.0 * kGap;
  const double top = frame.top + frame.height - kHeight - kGap;
  for (int i = 0; i < kSteps; ++i) {
    setHeatColor(cr, (i + 0.5) / kSteps);
    cairo_rectangle(cr, left + kWidth * i / kSteps, top, kWidth / kSteps, kHeight);
    cairo_fill(cr);
  }
  cairo_set_source_rgb(cr, 0.0, 0.0, 0.0);
  cairo_rectangle(cr, left, top, kWidth, kHeight);
  cairo_set_line_width(cr, 1.0);
  cairo_stroke(cr);
  cairo_move_to(cr, left - 2.0 * kGap, top + kHeight - 1.0);
  cairo_show_text(cr, "0 %");
  cairo_move_to(cr, left + kWidth + kText, top + kHeight - 1.0);
  cairo_show_text(cr, "100 %");
}

}  // namespace

void includeHeat(const PlotHeat& heat, Frame& frame) {
  frame.x.include(heat.first.x() - 0.5 * heat.step);
  frame.x.include(heat.first.x() + (heat.columns - 0.5) * heat.step);
  frame.y.include(heat.first.y() - 0.5 * heat.step);
  frame.y.include(heat.first.y() + (heat.rows - 0.5) * heat.step);
}

void drawHeat(cairo_t* cr, const PlotHeat& heat, const Frame& frame) {
  cairo_save(cr);
  cairo_set_antialias(cr, CAIRO_ANTIALIAS_NONE);  // no gaps between the cells
  for (int row = 0; row < heat.rows; ++row) {
    for (int column = 0; column < heat.columns; ++column) {
      const double left = heat.first.x() + (column - 0.5) * heat.step;
      const double low = heat.first.y() + (row - 0.5) * heat.step;
      const double x = frame.px(left), y = frame.py(low + heat.step);
      setHeatColor(cr, static_cast<double>(
                           heat.values[static_cast<std::size_t>(row * heat.columns + column)]));
      cairo_rectangle(cr, x, y, frame.px(left + heat.step) - x, frame.py(low) - y);
      cairo_fill(cr);
    }
  }
  cairo_restore(cr);
  drawScale(cr, frame);
}

}  // namespace kestrel
