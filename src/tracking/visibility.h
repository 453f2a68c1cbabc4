// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/tracking/motion_grid.h"

namespace kestrel {

constexpr double kHiddenShare = 0.3;  ///< an object is hidden if less of it is visible

/// How far the beams of a scan go in each direction: tells whether the sensor can see a place.
class Visibility {
 public:
  explicit Visibility(const std::vector<GridRay<2>>& rays);

  /// Share of an object of `width` (m) around `center` that beams reach: 0 outside of the field of
  /// view and behind something, 1 if nothing is in between.
  double visibleShare(const Eigen::Vector2d& center, double width) const;
  /// True if something nearer hides the place beside the points, so that they may be only a part of
  /// an object.
  bool isCut(const std::vector<Eigen::Vector2d>& points) const;
  /// True if a beam toward the point ended before it.
  bool isHidden(const Eigen::Vector2d& point) const {
    return isHiddenAt(bearingOf(point), rangeOf(point));
  }
  /// True if the beams toward the point and those beside it went farther: nothing is there. On a
  /// wall at a grazing angle, a beam passes closely before each part, and ends on the next part.
  bool isSeenThrough(const Eigen::Vector2d& point, double width) const {
    return isPassed(reach_, point, width);
  }
  /// The same by beams with a return only: glass, dark or grazed surfaces give none.
  bool isSeenThroughByReturns(const Eigen::Vector2d& point, double width) const {
    return isPassed(returns_, point, width);
  }
  /// Angle between two neighboring beams, rad; 0 without beams.
  double beamStep() const { return beam_step_; }
  Eigen::Vector2d directionTo(const Eigen::Vector2d& point) const {
    return (point - sensor_).normalized();
  }
  double rangeOf(const Eigen::Vector2d& point) const { return (point - sensor_).norm(); }

 private:
  static constexpr int kBins = 1440;  ///< of a quarter of a degree
  static int binOf(double bearing);
  double bearingOf(const Eigen::Vector2d& point) const;
  bool isPassed(const std::vector<float>& reach, const Eigen::Vector2d& point, double width) const;
  bool isHiddenAt(double bearing, double range) const;
  struct Beams {
    int measured = 0, visible = 0;
  };
  /// Bins with a beam, and those whose beam reaches `range`, of `count` neighboring bins.
  Beams countIn(int first, int count, double range) const;

  Eigen::Vector2d sensor_ = Eigen::Vector2d::Zero();
  std::vector<float> reach_;    ///< farthest beam of each bin, m; negative: no beam
  std::vector<float> returns_;  ///< the same of the beams with a return
  double beam_step_ = 0.0;
};

}  // namespace kestrel
