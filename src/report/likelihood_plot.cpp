// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/likelihood_plot.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/report/plot.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {
namespace {

constexpr double kEllipseSigmas = 3.0;
constexpr double kSquare = 3.4;  // height that makes a panel about square
constexpr std::size_t kBlue = 0, kTeal = 5;

/// The likelihood of every position, relative to the best one.
PlotHeat heatOf(const LikelihoodSurface& surface) {
  PlotHeat heat;
  heat.columns = heat.rows = surface.side();
  heat.first = surface.pose(-surface.linear_steps, -surface.linear_steps, 0).translation();
  heat.step = surface.step_m;
  heat.values = bestOverYaws(surface);
  const float best = *std::max_element(heat.values.begin(), heat.values.end());
  for (float& value : heat.values) value /= best;
  return heat;
}

/// Where the line between two neighboring cells crosses the level.
void addCrossing(const PlotHeat& heat, const Eigen::Vector2i& a, const Eigen::Vector2i& b,
                 float level, std::vector<Eigen::Vector2d>& points) {
  const auto valueAt = [&heat](const Eigen::Vector2i& cell) {
    return heat.values[static_cast<std::size_t>(cell.y() * heat.columns + cell.x())];
  };
  const float from = valueAt(a), to = valueAt(b);
  if ((from < level) == (to < level)) return;
  const double share = static_cast<double>((level - from) / (to - from));
  points.emplace_back(heat.first +
                      heat.step * ((1.0 - share) * a.cast<double>() + share * b.cast<double>()));
}

/// The contour of a level, found in each square of four cells. A square with four crossings (a
/// saddle) gives two lines.
PlotSeries contourOf(const PlotHeat& heat, float level, std::size_t color) {
  PlotSeries contour{
      std::to_string(std::lround(100.0F * level)) + " %", {}, PlotSeries::Style::kSegments, color};
  for (int y = 0; y + 1 < heat.rows; ++y) {
    for (int x = 0; x + 1 < heat.columns; ++x) {
      const Eigen::Vector2i corners[] = {{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}, {x, y}};
      std::vector<Eigen::Vector2d> points;
      for (int i = 0; i < 4; ++i) addCrossing(heat, corners[i], corners[i + 1], level, points);
      contour.points.insert(contour.points.end(), points.begin(), points.end());
    }
  }
  return contour;
}

PlotSeries ellipseOf(const MapperResult& result) {
  constexpr int kCorners = 72;
  PlotSeries ellipse{"3 sigma ellipse", {}, PlotSeries::Style::kLine, kTeal};
  const Eigen::Matrix2d covariance = result.match.covariance.topLeftCorner<2, 2>();
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    const Eigen::Vector2d unit(std::cos(angle), std::sin(angle));
    ellipse.points.emplace_back(result.match.pose.translation() + kEllipseSigmas * (root * unit));
  }
  return ellipse;
}

}  // namespace

LikelihoodRecorder::LikelihoodRecorder(const MapperConfig& mapper, std::size_t scan)
    : mapper_(mapper), wanted_(scan), map_(mapper) {
  if (scan == 0) {
    throw std::invalid_argument(
        "scan 0 defines the map, so it has no likelihood; choose a later scan");
  }
}

void LikelihoodRecorder::add(const PlanarScan& scan, const MapperResult& result) {
  if (scans_++ == wanted_) {
    result_ = result;
    surface_ = sampleLikelihood(map_.map().surface(), hitsOf(scan), result.pose,
                                mapper_.matcher.near_window, mapper_.matcher.correlative);
  }
  map_.add(scan, result);
}

void LikelihoodRecorder::write(const std::string& path) const {
  if (surface_.score.empty()) {
    throw std::runtime_error("scan " + std::to_string(wanted_) + " cannot be shown: the run has " +
                             std::to_string(scans_) + " scans, or this scan has no hits");
  }
  PlotPanel panel;
  panel.title = "likelihood of scan " + std::to_string(wanted_) + ", relative to the best pose";
  panel.x_label = "x in map (m)";
  panel.y_label = "y in map (m)";
  panel.heat = heatOf(surface_);
  panel.series = {contourOf(panel.heat, 0.85F, kPlotBlack), contourOf(panel.heat, 0.95F, kBlue),
                  ellipseOf(result_)};
  panel.series.push_back(
      {"matched pose", {result_.match.pose.translation()}, PlotSeries::Style::kDots, kPlotBlack});
  panel.equal_axes = true;
  panel.height = kSquare;
  writePlot(path, {panel});
}

}  // namespace kestrel
