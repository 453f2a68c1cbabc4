// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kestrel_slam/matching/correlative.h"

namespace kestrel {

/// The score of every pose of a window, as maximized by the exhaustive search but without the
/// penalty of the motion. Shows peaks, ridges (in a corridor) and ambiguous maxima.
struct LikelihoodSurface {
  Pose2 center;              ///< pose of step (0, 0, 0)
  double step_m = 0.0;       ///< step in x and y
  double step_rad = 0.0;     ///< step of the yaw
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

/// Scores every pose of the window. The time is proportional to its volume: with ±0.5 m, ±20° and 3
/// cm steps about ten times the time of the search. Empty without points. Throws
/// std::invalid_argument for more than 50 million poses.
LikelihoodSurface sampleLikelihood(const SurfelField& surface, const Points& points,
                                   const Pose2& center, const SearchWindow& window,
                                   const CorrelativeConfig& config);

/// The highest score over all yaws for every (x, y): an image of `side()` × `side()`, row by row,
/// starting at the lowest y.
std::vector<float> bestOverYaws(const LikelihoodSurface& surface);

/// Mean and covariance of a pose with the distribution of the surface.
struct PoseMoments {
  Pose2 mean;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of (x, y, yaw), m² and rad²
  /// Share of the likelihood, 0 to 1, in the outermost poses in x and y, and in yaw. If it is
  /// large, the distribution continues outside the surface.
  double linear_border = 0.0, angular_border = 0.0;
};

/// Moments of the surface, each pose weighted by its likelihood ([Olson 2009, eq. 5-7]; sampled
/// covariance of [Kohlbrecher 2011, sec. IV-B]). The score is a mean over beams, and neighboring
/// beams are not independent. The likelihood is therefore exp(n · score), with n the number of
/// independent beams. The surface must not be empty.
PoseMoments momentsOf(const LikelihoodSurface& surface);

}  // namespace kestrel
