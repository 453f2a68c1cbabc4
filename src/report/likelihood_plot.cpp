// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/likelihood_plot.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kestrel_slam/geometry/angles.h"
#include "kestrel_slam/report/plot.h"
#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {
namespace {

/// Levels that are shown, relative to the best score.
constexpr std::array<float, 4> kLevels = {0.5F, 0.7F, 0.85F, 0.95F};
constexpr double kEllipseSigmas = 3.0;
constexpr double kSquare = 3.4;  // height that makes a panel about square

/// Adds the poses between each level and the next higher one.
std::vector<PlotSeries> levelsOf(const LikelihoodSurface& surface) {
  const std::vector<float> image = bestOverYaws(surface);
  const float best = *std::max_element(image.begin(), image.end());
  std::vector<PlotSeries> levels;
  for (const float level : kLevels) {
    const std::string name = std::to_string(std::lround(100.0F * level)) + " %";
    levels.push_back({name, {}, PlotSeries::Style::kDots});
  }
  for (std::size_t i = 0; i < image.size(); ++i) {
    const auto above = std::upper_bound(kLevels.begin(), kLevels.end(), image[i] / best);
    if (above == kLevels.begin()) continue;
    const int column = static_cast<int>(i) % surface.side();
    const int row = static_cast<int>(i) / surface.side();
    const Pose2 pose = surface.pose(column - surface.linear_steps, row - surface.linear_steps, 0);
    levels[static_cast<std::size_t>(above - kLevels.begin()) - 1].points.push_back(
        pose.translation());
  }
  return levels;
}

PlotSeries ellipseOf(const MapperResult& result) {
  constexpr int kCorners = 72;
  PlotSeries ellipse{"3 sigma ellipse", {}, PlotSeries::Style::kLine};
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
  panel.series = levelsOf(surface_);
  panel.series.push_back(ellipseOf(result_));
  panel.series.push_back(
      {"matched pose", {result_.match.pose.translation()}, PlotSeries::Style::kDots});
  panel.equal_axes = true;
  panel.height = kSquare;
  writePlot(path, {panel});
}

}  // namespace kestrel
