// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace kestrel {

/// A rectangle in the plane with any yaw.
struct OrientedBox {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d size =
      Eigen::Vector2d::Zero();  ///< along the axes of the box, m; x is the longer
  double yaw = 0.0;             ///< of the longer side, in (-pi/2, pi/2]

  /// True up to `margin` (m) outside of its sides.
  bool contains(const Eigen::Vector2d& point, double margin = 0.0) const;
};

/// The smallest rectangle with this yaw around the points.
OrientedBox boxAlong(const std::vector<Eigen::Vector2d>& points, double yaw);

/// The rectangle whose sides lie closest to the points [Zhang 2017, closeness criterion]: for a
/// vehicle of which the laser sees one or two sides. No points: an empty box.
OrientedBox fitBox(const std::vector<Eigen::Vector2d>& points);

/// Two visible sides of a box that meet at `corner`.
struct LShape {
  Eigen::Vector2d corner;
  Eigen::Vector2d first_end, second_end;  ///< of the visible sides
};

/// The sides of the box that face the sensor. Nothing if only one side faces it.
std::optional<LShape> lShapeOf(const OrientedBox& box, const Eigen::Vector2d& sensor);

}  // namespace kestrel
