// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "rough_search.h"
#include "wall_image.h"

namespace kestrel {

/// A rectangle of poses of a RoughGrid: steps in x and y from (dx, dy) on.
struct RoughPart {
  /// Number of columns that are summed at once, and maximum number of rows.
  static constexpr int kSide = 16;
  int dx, dy, columns, rows;
};

/// Poses in steps of one pixel and one angular step, and how well some points of the scan fit
/// there.
class RoughGrid {
 public:
  using Sums = std::array<std::int16_t, static_cast<std::size_t>(RoughPart::kSide) *
                                            static_cast<std::size_t>(RoughPart::kSide)>;

  /// Pixels of 2^shift cells.
  RoughGrid(const SurfelField& surface, const Points& points, const RoughWindow& window, int shift);

  int linearSteps() const { return linear_steps_; }
  int angularSteps() const { return angular_steps_; }
  double pixel() const { return pixel_m_; }
  double angularStep() const { return angular_step_; }
  Pose2 pose(int k, int dx, int dy) const;
  double score(int sum) const { return sum * score_of_one_; }

  /// The image of the walls that the points can reach.
  std::shared_ptr<const WallImage> imageOf(const SurfelField& surface) const;
  /// Whether an image shows all that `imageOf` the same map would show.
  bool isIn(const WallImage* image) const;

  /// Rotates the points by `k` steps in `imageOf` the surface.
  void rotate(const WallImage& image, int k);
  /// Adds up the values of all points for the poses of `part`, at the angle of the last rotation.
  void sum(const RoughPart& part, Sums& sums) const;

  std::int64_t imageWork() const;
  std::int64_t rotationWork() const;
  std::int64_t sumWork(const RoughPart& part) const;

 private:
  RoughWindow window_;
  int shift_;
  double pixel_m_;
  double angular_step_ = 1.0;
  int linear_steps_, angular_steps_ = 0;
  std::vector<float> x_, y_;   ///< the points in the base frame, pixels
  std::vector<int> layer_of_;  ///< for each point
  CellBox box_{};              ///< the cells that the points can reach
  int layers_ = 1;
  double score_of_one_ = 0.0;
  std::vector<const std::uint8_t*> pixels_;  ///< of the rotated points
  int stride_ = 0;
};

}  // namespace kestrel
