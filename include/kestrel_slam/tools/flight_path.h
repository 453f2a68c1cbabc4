#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"

namespace kestrel_slam {

/// A smooth closed flight: hover, speed up, along a curve at constant speed, slow down, hover where
/// it began. The nose points along the curve.
class FlightPath {
 public:
  /// `corners`: control points of a closed uniform cubic B-spline (m), at least three; the curve
  /// stays inside their convex hull and cuts the corners. Throws std::invalid_argument on fewer or
  /// a speed that is not positive.
  FlightPath(const std::vector<Eigen::Vector2d>& corners, double speed_m_s);

  double length() const { return arc_length_.back(); }
  double duration() const;

  /// map_T_base at `time` (s) after take-off; before and after the flight it hovers.
  Pose2 at(double time) const;

 private:
  double travelledAt(double time) const;
  double parameterAt(double travelled) const;

  std::vector<Eigen::Vector2d> corners_;
  double speed_m_s_;
  std::vector<double> arc_length_;  ///< from the start to each sample of the curve, m
};

}  // namespace kestrel_slam
