// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/ros/mapper/uncertainty_markers.h"

#include <algorithm>
#include <cmath>

#include "kestrel_slam/geometry/symmetric_axes.h"

namespace kestrel {
namespace {

using visualization_msgs::Marker;

constexpr double kSigmas = 3.0;
/// Smallest diameter that is visible in rviz, m.
constexpr double kMinDiameter = 0.02;
constexpr double kHeight = 0.01, kLineWidth = 0.05;  // m
/// Half of the line length, m.
constexpr double kHalfLength = 2.0;

void setColor(Marker& marker, float red, float green, float blue, float alpha) {
  marker.color.r = red;
  marker.color.g = green;
  marker.color.b = blue;
  marker.color.a = alpha;
}

Marker ellipseOf(const MapperResult& result) {
  Marker marker;
  marker.ns = "covariance";
  marker.type = Marker::CYLINDER;
  const SymmetricAxes<2> axes =
      symmetricAxes(Eigen::Matrix2d(result.covariance.topLeftCorner<2, 2>()));
  const Eigen::Vector2d sigmas = axes.eigenvalues.cwiseMax(0.0).cwiseSqrt();
  const Eigen::Vector2d long_axis = axes.eigenvectors.col(1);
  const double angle = std::atan2(long_axis.y(), long_axis.x());
  marker.pose.position.x = result.pose.x;
  marker.pose.position.y = result.pose.y;
  marker.pose.orientation.z = std::sin(0.5 * angle);
  marker.pose.orientation.w = std::cos(0.5 * angle);
  marker.scale.x = std::max(2.0 * kSigmas * sigmas(1), kMinDiameter);
  marker.scale.y = std::max(2.0 * kSigmas * sigmas(0), kMinDiameter);
  marker.scale.z = kHeight;
  setColor(marker, 0.8F, 0.2F, 0.8F, 0.4F);
  return marker;
}

Marker directionOf(const MapperResult& result) {
  Marker marker;
  marker.ns = "degeneracy";
  marker.id = 1;
  marker.type = Marker::LINE_LIST;
  marker.action = result.match.degenerate ? Marker::ADD : Marker::DELETE;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = kLineWidth;
  for (const double side : {-kHalfLength, kHalfLength}) {
    const Eigen::Vector2d end =
        result.pose.translation() + side * result.match.degenerate_direction;
    marker.points.emplace_back();
    marker.points.back().x = end.x();
    marker.points.back().y = end.y();
  }
  setColor(marker, 0.9F, 0.1F, 0.1F, 1.0F);
  return marker;
}

}  // namespace

visualization_msgs::MarkerArray uncertaintyMarkers(const MapperResult& result) {
  visualization_msgs::MarkerArray markers;
  markers.markers = {ellipseOf(result), directionOf(result)};
  return markers;
}

}  // namespace kestrel
