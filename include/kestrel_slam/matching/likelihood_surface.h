// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/matching/correlative.h"

namespace kestrel {

/// The score of every pose of a window: what the exhaustive search maximizes, without the cost of
/// the motion. Peaks, ridges (a corridor) and second maxima are seen in it.
struct LikelihoodSurface {
  Pose2 center;              ///< of the step (0, 0, 0)
  double step_m = 0.0;       ///< in x and y
  double step_rad = 0.0;     ///< of the yaw
  int linear_steps = 0;      ///< ± in x and y
  int angular_steps = 0;     ///< ±
  std::vector<float> score;  ///< mean likelihood of the points, 0 to 1; x fastest, yaw slowest

  int side() const { return 2 * linear_steps + 1; }
  std::size_t index(int dx, int dy, int k) const {
    const int row = (k + angular_steps) * side() + dy + linear_steps;
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side()) +
           static_cast<std::size_t>(dx + linear_steps);
  }
  float at(int dx, int dy, int k) const { return score[index(dx, dy, k)]; }
  Pose2 pose(int dx, int dy, int k) const {
    return {center.x + dx * step_m, center.y + dy * step_m, center.yaw + k * step_rad};
  }
};

/// Scores every pose of the window; the time grows with its volume (±0.5 m, ±20° in steps of 3 cm:
/// about ten times that of the search). Empty without points. Throws std::invalid_argument for more
/// than 50 million poses.
LikelihoodSurface sampleLikelihood(const SurfelField& surface, const Points& points,
                                   const Pose2& center, const SearchWindow& window,
                                   const CorrelativeConfig& config);

/// The highest score over all yaws for every (x, y), row by row from the lowest y on: an image
/// of `side()` × `side()`.
std::vector<float> bestOverYaws(const LikelihoodSurface& surface);

/// Mean and covariance of a pose that is distributed as the surface says.
struct PoseMoments {
  Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), m² and rad²
  /// Share of the likelihood, 0 to 1, in the outermost poses of x and y, and in those of the
  /// yaw: where it is large, the surface goes on beyond its border.
  double linear_border = 0.0, angular_border = 0.0;
};

/// Sums over the surface, each pose weighted by its likelihood (Olson eq. 5-7, paper 001's sampled
/// covariance). The score is a mean over beams of which neighbors see the same wall: as likelihood
/// counts exp(n · score) with the n of that many independent beams. Needs a surface with poses.
PoseMoments momentsOf(const LikelihoodSurface& surface);

}  // namespace kestrel
