// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/report/slice_plot.h"

#include "kestrel_slam/report/plot.h"

namespace kestrel {

void writeSlicePlot(const std::string& path, const std::string& title, const PointCloud& cloud,
                    const Eigen::Isometry3d& base_T_lidar, const PlanarScan& slice,
                    double radius_m) {
  constexpr double kSquare = 3.4;  // height that makes a panel about square
  PlotSeries whole{"cloud", {}, PlotSeries::Style::kDots};
  PlotSeries hits{"hits of the slice", {}, PlotSeries::Style::kDots};
  PlotSeries clears{"end of free space", {}, PlotSeries::Style::kDots};
  for (const PointCloud::Point& point : cloud.points) {
    const Eigen::Vector3d p = base_T_lidar * Eigen::Vector3d(point.x, point.y, point.z);
    if (p.allFinite() && p.head<2>().norm() <= radius_m) whole.points.emplace_back(p.head<2>());
  }
  for (const PlanarRay& ray : slice.rays) {
    (ray.hit ? hits : clears).points.emplace_back(ray.end.cast<double>());
  }
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "x, forward (m)";
  panel.y_label = "y, left (m)";
  panel.series = {whole, hits, clears};
  panel.equal_axes = true;
  panel.height = kSquare;
  writePlot(path, {panel});
}

}  // namespace kestrel
