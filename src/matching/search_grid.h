// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "kestrel_slam/matching/correlative.h"

namespace kestrel {

/// A pose of the search, in steps from the center of the window.
struct GridPose {
  int k = 0;  ///< angular steps
  int dx = 0, dy = 0;
};

/// The cell of a point.
struct PointCell {
  std::int32_t x, y;
};

/// A rectangle of cells: x in [low.x, high.x), y in [low.y, high.y).
struct CellBox {
  Cell low, high;
};

/// The discretized window and the points of the search.
class SearchGrid {
 public:
  SearchGrid(const SurfelField& surface, const Points& points, const Pose2& center,
             const SearchWindow& window, const CorrelativeConfig& config);

  int linearSteps() const { return linear_steps_; }
  int angularSteps() const { return angular_steps_; }
  double angularStep() const { return angular_step_; }
  double resolution() const { return resolution_; }
  int pointCount() const { return static_cast<int>(points_.size()); }
  /// All cells that a point can reach if the scan is rotated at the center, without translation.
  CellBox reach() const;

  /// Cells of the points [first, first + count), relative to `box.low`, with the scan rotated by
  /// `k` steps at the center. Points outside of `box` are moved to its border.
  void rotate(int k, int first, int count, const CellBox& box, PointCell* cells) const;

  /// Penalty of a motion: the minimum over the block of `size` × `size` cells that begins at
  /// `pose`.
  double motionPenalty(const GridPose& pose, int size) const;
  /// The mean likelihood for a sum over all points.
  double score(int sum) const { return static_cast<double>(sum) * score_of_one_; }
  Pose2 pose(const GridPose& at) const;

 private:
  std::vector<Eigen::Vector2f> points_;  ///< in cells; every prefix is a sample of the whole scan
  Pose2 center_;
  CorrelativeConfig config_;
  double resolution_;
  float range_ = 0.0F;  ///< range of the farthest point, cells
  int linear_steps_, angular_steps_;
  double angular_step_;
  double score_of_one_ = 0.0;
};

}  // namespace kestrel
