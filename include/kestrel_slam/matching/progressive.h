// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "kestrel_slam/geometry/pose2.h"
#include "kestrel_slam/map/occupancy_grid.h"
#include "kestrel_slam/matching/gauss_newton.h"
#include "kestrel_slam/matching/match_result.h"

namespace kestrel {

/// Parameters of the progressive refinement [Xie 2010], which gives no values.
struct ProgressiveConfig {
  int seed = 1;  ///< of the random candidates; the same seed gives identical poses
  /// n1, number of candidates on the 20 cm level, which covers the largest space.
  int coarse_candidates = 400;
  int fine_candidates = 400;   ///< n2 = n3, on the 10 and the 5 cm level
  int wide_candidates = 3000;  ///< for a larger space, if no pose near the prediction fits
  double motion_share = 0.3;   ///< λ1 = λ2 of eq. 8-9: sigma of x and y per meter of motion
  double turn_share = 0.3;     ///< λ3 of eq. 10: sigma of the yaw per radian of motion
  /// Minimum sigma, so that a motion from rest is found: half a coarse cell.
  double min_sigma_m = 0.1;
  /// The same at 2 m distance. 400 candidates cover no larger space.
  double min_sigma_rad = 0.05;
  double shrink = 0.5;  ///< factor of the candidate space from level to level, as the cell size
  /// A correction below this many cells of the coarser level never stops the refinement, because
  /// the coarser level cannot resolve it; 0: as in the paper.
  double slack_cells = 0.5;
  double beams = 100.0;  ///< logarithm of the likelihood of a scan if all points vote
};

/// Standard deviations of candidates around their center.
struct CandidateSpread {
  double linear_m = 0.0;     ///< of x and y, in the map frame
  double angular_rad = 0.0;  ///< of the yaw
};

/// Standard normal samples of (x, y, yaw), the most likely first. The first one is zero.
using StandardCandidates = std::vector<Eigen::Vector3f>;

/// `count` samples, generated as in the sampling algorithm that [Xie 2010] cites: [Thrun 2005,
/// table 5.4]. Depends only on its arguments.
StandardCandidates standardCandidates(int count, int seed);

/// The spread of the motion model around the prediction x* = `initial_guess` [Xie 2010, eq. 7-10].
/// The text calls δ = λ v a variance, but eq. 8-10 square it, so it is the standard deviation. The
/// velocity is the motion per scan, from `last` to `initial_guess`. x and y of the map are
/// equivalent, so λ1 = λ2. Poses are in the map frame.
CandidateSpread motionSpread(const Pose2& last, const Pose2& initial_guess,
                             const ProgressiveConfig& config);

/// Mean over the points of the probability of the cell that each point hits on `level`, or 0 if the
/// cell is not occupied ([Xie 2010, eq. 21], divided by the number of points). 0 without points.
double votingLikelihood(const OccupancyGrid& grid, int level, const Points& points,
                        const Pose2& map_T_base);

/// Estimate of one level.
struct LevelEstimate {
  Pose2 pose;  ///< of the best candidate [Xie 2010, eq. 19]
  Pose2 mean;  ///< mean of the candidates, weighted by likelihood; more accurate than their spacing
  double vote = 0.0;  ///< of the best candidate [Xie 2010, eq. 21]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the weighted candidates: the
                                                         ///< sampled posterior of [Xie 2010, eq. 4]
};

/// The candidate around `center` with the largest P(z|x, M) P(x|x*) [Xie 2010, eq. 19]. Eq. 21 only
/// gives the order of the votes; here log P(z|x, M) = `beams` × vote. The center if no point votes.
LevelEstimate bestCandidate(const OccupancyGrid& grid, int level, const Points& points,
                            const Pose2& center, const CandidateSpread& spread,
                            const StandardCandidates& candidates, double beams);

/// The estimates of the levels [Xie 2010, fig. 4], coarse to fine.
struct Refinement {
  /// x(i); after a stop the remaining ones equal the last accepted one.
  std::array<Pose2, kMatchStages> poses;
  std::array<CandidateSpread, kMatchStages> spreads;
  std::array<double, kMatchStages> corrections_m{};  ///< |x(i) - x*(i)|, including the rejected one
  int levels = 0;                                    ///< number of accepted levels
  bool stopped = false;  ///< a finer correction exceeded the coarser one
  LevelEstimate finest;  ///< the finest accepted estimate
};

/// Refines a pose over the levels of a grid. The only state are the candidates, which are drawn
/// once.
class ProgressiveRefiner {
 public:
  explicit ProgressiveRefiner(const ProgressiveConfig& config);

  /// Every level starts at the estimate of the coarser one, with a candidate space that is smaller
  /// by the factor `shrink`. If the correction of a level exceeds the previous one, the refinement
  /// stops and keeps the coarser estimate. The paper does not define |·| of a pose. Here it is the
  /// displacement of a point at the mean range of the scan. With the exact rule the refinement
  /// would stop at every second scan of a real recording, because the prediction of the coarse
  /// level may be accurate by chance; see `slack_cells`.
  Refinement refine(const OccupancyGrid& grid, const Points& points, const Pose2& initial_guess,
                    const CandidateSpread& spread) const;

  /// The best of the wide candidates on the coarsest level.
  Pose2 findCoarsely(const OccupancyGrid& grid, const Points& points, const Pose2& center,
                     const CandidateSpread& spread) const;

 private:
  ProgressiveConfig config_;
  StandardCandidates coarse_, fine_, wide_;
};

}  // namespace kestrel
