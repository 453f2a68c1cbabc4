// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/plot.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <stdexcept>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/map/atomic_file.h"
#include "plot_frame.h"

namespace kestrel {
namespace {

// All lengths in pixels.
constexpr int kWidth = 1000;
constexpr double kUnitHeight = 290.0;
constexpr double kPadLeft = 75.0, kPadRight = 25.0, kPadTop = 40.0, kPadBottom = 55.0;
constexpr double kTickLength = 5.0, kLabelGap = 8.0;
constexpr double kFontSize = 14.0, kTitleSize = 16.0;
constexpr double kDotRadius = 1.5, kSingleDotRadius = 2.5, kLineWidth = 1.3, kContourWidth = 2.2;
constexpr double kWantedTicks = 7.0;
constexpr double kMargin = 0.04;  // margin around the data, relative to its extent

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;
using Context = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;

struct Color {
  double r, g, b;
};
constexpr std::array<Color, 9> kColors = {{{0.12, 0.40, 0.70},
                                           {0.85, 0.37, 0.01},
                                           {0.17, 0.55, 0.25},
                                           {0.55, 0.30, 0.65},
                                           {0.80, 0.10, 0.25},
                                           {0.10, 0.65, 0.70},
                                           {0.50, 0.35, 0.15},
                                           {0.45, 0.45, 0.45},
                                           {0.0, 0.0, 0.0}}};

void makeUsable(Range& range) {
  if (!(range.size() >= 0.0)) range = {0.0, 1.0};
  const double least = std::max(1e-6, 1e-9 * std::max(std::abs(range.min), std::abs(range.max)));
  range.grow(std::max(2.0 * kMargin * range.size(), least));
}

void setRanges(const PlotPanel& panel, Frame& frame) {
  for (const PlotSeries& series : panel.series) {
    for (const Eigen::Vector2d& point : series.points) {
      const double y = frame.onScale(point.y());
      if (!std::isfinite(point.x()) || !std::isfinite(y)) continue;
      frame.x.include(point.x());
      frame.y.include(y);
    }
  }
  if (panel.heat.columns > 0) includeHeat(panel.heat, frame);
  if (panel.from_zero) frame.y.include(0.0);
  makeUsable(frame.x);
  makeUsable(frame.y);
  if (!panel.equal_axes) return;
  const double scale = std::max(frame.x.size() / frame.width, frame.y.size() / frame.height);
  frame.x.grow(scale * frame.width - frame.x.size());
  frame.y.grow(scale * frame.height - frame.y.size());
}

/// 1, 2 or 5 times a power of ten.
double tickStep(const Range& range, double wanted) {
  const double raw = range.size() / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10.0 * power;
}

std::string tickText(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value + 0.0);  // no "-0"
  return text;
}

enum class Align { kLeft, kCenter, kRight };

void drawText(cairo_t* cr, double x, double y, const std::string& text, Align align) {
  cairo_text_extents_t extents;
  cairo_text_extents(cr, text.c_str(), &extents);
  const double shift = align == Align::kLeft ? 0.0 : align == Align::kCenter ? 0.5 : 1.0;
  cairo_move_to(cr, x - shift * extents.x_advance, y);
  cairo_show_text(cr, text.c_str());
}

void drawLine(cairo_t* cr, double x1, double y1, double x2, double y2, double gray) {
  cairo_set_source_rgb(cr, gray, gray, gray);
  cairo_move_to(cr, x1, y1);
  cairo_line_to(cr, x2, y2);
  cairo_stroke(cr);
}

constexpr double kGridGray = 0.9;

void drawTickY(cairo_t* cr, const Frame& frame, double value, const std::string& text) {
  const double y = frame.py(value);
  drawLine(cr, frame.left, y, frame.left + frame.width, y, kGridGray);
  cairo_set_source_rgb(cr, 0.0, 0.0, 0.0);
  drawText(cr, frame.left - kLabelGap, y + kFontSize / 3.0, text, Align::kRight);
}

/// Ticks of a logarithmic axis: the powers of ten. If there are few decades, also their multiples,
/// with labels at 2 and 5.
void drawPowers(cairo_t* cr, const Frame& frame) {
  constexpr double kFewDecades = 3.0;
  for (double decade = std::floor(frame.y.min); decade <= frame.y.max; ++decade) {
    for (int factor = 1; factor < 10; ++factor) {
      const double value = factor * std::pow(10.0, decade), y = std::log10(value);
      if (y < frame.y.min || y > frame.y.max) continue;
      if (factor > 1 && frame.y.size() > kFewDecades) continue;
      const bool labeled = factor == 1 || factor == 2 || factor == 5;
      drawTickY(cr, frame, value, labeled ? tickText(value, std::pow(10.0, decade)) : "");
    }
  }
}

/// Less than half a decade may contain none of these labels.
bool needsPowers(const Frame& frame) {
  constexpr double kHalfDecade = 0.5;
  return frame.log_y && frame.y.size() > kHalfDecade;
}

/// Evenly spaced ticks; on a logarithmic axis too, if it shows a small range.
void drawEvenTicks(cairo_t* cr, const Frame& frame) {
  const auto valueOf = [&](double y) { return frame.log_y ? std::pow(10.0, y) : y; };
  Range values;
  values.include(valueOf(frame.y.min));
  values.include(valueOf(frame.y.max));
  const double step = tickStep(values, kWantedTicks * std::sqrt(frame.height / frame.width));
  for (double i = std::ceil(values.min / step); i * step <= values.max; ++i) {
    if (!frame.log_y || i > 0.0) drawTickY(cr, frame, i * step, tickText(i * step, step));
  }
}

void drawTicks(cairo_t* cr, const Frame& frame) {
  const double bottom = frame.top + frame.height;
  const double x_step = tickStep(frame.x, kWantedTicks);
  cairo_set_line_width(cr, 1.0);
  for (double i = std::ceil(frame.x.min / x_step); i * x_step <= frame.x.max; ++i) {
    const double x = frame.px(i * x_step);
    drawLine(cr, x, frame.top, x, bottom, kGridGray);
    cairo_set_source_rgb(cr, 0.0, 0.0, 0.0);
    drawText(cr, x, bottom + kTickLength + kFontSize, tickText(i * x_step, x_step), Align::kCenter);
  }
  if (needsPowers(frame)) {
    drawPowers(cr, frame);
  } else {
    drawEvenTicks(cr, frame);
  }
}

void drawLabels(cairo_t* cr, const PlotPanel& panel, const Frame& frame) {
  cairo_set_source_rgb(cr, 0.0, 0.0, 0.0);
  cairo_rectangle(cr, frame.left, frame.top, frame.width, frame.height);
  cairo_stroke(cr);
  drawText(cr, frame.left + frame.width / 2.0, frame.top + frame.height + kPadBottom - kLabelGap,
           panel.x_label, Align::kCenter);
  cairo_save(cr);
  cairo_translate(cr, kFontSize + kLabelGap / 2.0, frame.top + frame.height / 2.0);
  cairo_rotate(cr, -kPi / 2.0);
  drawText(cr, 0.0, 0.0, panel.y_label + (panel.log_y ? " (log scale)" : ""), Align::kCenter);
  cairo_restore(cr);
  cairo_set_font_size(cr, kTitleSize);
  drawText(cr, frame.left, frame.top - kLabelGap, panel.title, Align::kLeft);
  cairo_set_font_size(cr, kFontSize);
}

void setColor(cairo_t* cr, const PlotSeries& series, std::size_t index) {
  const Color& color = kColors[series.color.value_or(index % kPlotBlack)];
  cairo_set_source_rgb(cr, color.r, color.g, color.b);
}

void drawSeries(cairo_t* cr, const PlotSeries& series, const Frame& frame) {
  const bool is_contour = series.style == PlotSeries::Style::kSegments;
  cairo_set_line_width(cr, is_contour ? kContourWidth : kLineWidth);
  const double radius = series.points.size() > 1 ? kDotRadius : kSingleDotRadius;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const double x = frame.px(series.points[i].x()), y = frame.py(series.points[i].y());
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    if (series.style == PlotSeries::Style::kDots) {
      cairo_new_sub_path(cr);
      cairo_arc(cr, x, y, radius, 0.0, 2.0 * kPi);
      cairo_fill(cr);
    } else if (is_contour && i % 2 == 0) {
      cairo_move_to(cr, x, y);
    } else {
      cairo_line_to(cr, x, y);
    }
  }
  cairo_stroke(cr);
}

/// Draws the legend above the frame, right-aligned, in the colors of the series.
void drawLegend(cairo_t* cr, const PlotPanel& panel, const Frame& frame) {
  constexpr double kGap = 20.0;
  double right = frame.left + frame.width;
  for (std::size_t i = panel.series.size(); i-- > 0;) {
    setColor(cr, panel.series[i], i);
    cairo_text_extents_t extents;
    cairo_text_extents(cr, panel.series[i].name.c_str(), &extents);
    drawText(cr, right, frame.top - kLabelGap, panel.series[i].name, Align::kRight);
    right -= extents.x_advance + kGap;
  }
}

void drawPanel(cairo_t* cr, const PlotPanel& panel, Frame frame) {
  frame.log_y = panel.log_y;
  setRanges(panel, frame);
  drawTicks(cr, frame);
  cairo_save(cr);
  cairo_rectangle(cr, frame.left, frame.top, frame.width, frame.height);
  cairo_clip(cr);
  if (panel.heat.columns > 0) drawHeat(cr, panel.heat, frame);
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    setColor(cr, panel.series[i], i);
    drawSeries(cr, panel.series[i], frame);
  }
  cairo_restore(cr);
  cairo_set_line_width(cr, 1.0);
  drawLabels(cr, panel, frame);
  drawLegend(cr, panel, frame);
}

void drawPanels(cairo_t* cr, const std::vector<PlotPanel>& panels) {
  cairo_set_source_rgb(cr, 1.0, 1.0, 1.0);
  cairo_paint(cr);
  cairo_select_font_face(cr, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cr, kFontSize);
  double top = 0.0;
  for (const PlotPanel& panel : panels) {
    const double height = panel.height * kUnitHeight;
    drawPanel(cr, panel,
              {kPadLeft,
               top + kPadTop,
               kWidth - kPadLeft - kPadRight,
               height - kPadTop - kPadBottom,
               {},
               {}});
    top += height;
  }
}

cairo_status_t appendTo(void* bytes, const unsigned char* data, unsigned int count) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), count);
  return CAIRO_STATUS_SUCCESS;
}

void requireSuccess(const std::string& path, cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw std::runtime_error(path + ": cannot be drawn: " + cairo_status_to_string(status));
}

void writePng(const std::string& path, const std::vector<PlotPanel>& panels, int height) {
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, kWidth, height),
                        cairo_surface_destroy);
  drawPanels(Context(cairo_create(surface.get()), cairo_destroy).get(), panels);
  std::string bytes;
  requireSuccess(path, cairo_surface_write_to_png_stream(surface.get(), appendTo, &bytes));
  writeFileAtomically(path, bytes);
}

void writeSvg(const std::string& path, const std::vector<PlotPanel>& panels, int height) {
  std::string bytes;
  const Surface surface(cairo_svg_surface_create_for_stream(appendTo, &bytes, kWidth, height),
                        cairo_surface_destroy);
  cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
  drawPanels(Context(cairo_create(surface.get()), cairo_destroy).get(), panels);
  cairo_surface_finish(surface.get());
  requireSuccess(path, cairo_surface_status(surface.get()));
  writeFileAtomically(path, bytes);
}

}  // namespace

void writePlot(const std::string& path, const std::vector<PlotPanel>& panels) {
  double total = 0.0;
  for (const PlotPanel& panel : panels) total += panel.height * kUnitHeight;
  const int height = static_cast<int>(std::ceil(total));
  writePng(path, panels, height);
  writeSvg(std::filesystem::path(path).replace_extension(".svg").string(), panels, height);
}

}  // namespace kestrel
