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

/// Parameters of the progressive refinement (paper 002, which gives no values).
struct ProgressiveConfig {
  int seed = 1;  ///< of the candidates: the same seed, the same poses to the last bit
  int coarse_candidates = 400;  ///< n1, on the 20 cm level, which has the largest space
  int fine_candidates = 400;    ///< n2 = n3, on the 10 and the 5 cm level
  int wide_candidates = 3000;   ///< where nothing near the prediction fits: a larger space
  double motion_share = 0.3;    ///< λ1 = λ2 of eq. 8-9: sigma of x and y per meter moved
  double turn_share = 0.3;      ///< λ3 of eq. 10: sigma of the yaw per radian turned
  double min_sigma_m = 0.1;     ///< a standing vehicle has to be able to start: half a coarse cell,
  double min_sigma_rad = 0.05;  ///< and the same 2 m away; 400 candidates fill no more
  double shrink = 0.5;          ///< of the candidate space from level to level, as the cells shrink
  double slack_cells = 0.5;     ///< a correction of up to so many cells of the coarser level never
                                ///< stops the refinement: it could not be seen there; 0: eq. as is
  double beams = 100.0;         ///< logarithm of the likelihood of a scan all of whose points vote
};

/// Standard deviations of candidates around their center.
struct CandidateSpread {
  double linear_m = 0.0;     ///< of x and y, in map
  double angular_rad = 0.0;  ///< of the yaw
};

/// Standard normal (x, y, yaw), the likeliest first; the first is zero.
using StandardCandidates = std::vector<Eigen::Vector3f>;

/// `count` of them, by the generator of the sampling algorithm that paper 002 cites (Thrun et al.,
/// "Probabilistic Robotics", table 5.4). A function of its arguments alone.
StandardCandidates standardCandidates(int count, int seed);

/// The spread of the motion model around the prediction x* = `initial_guess` (paper 002 eq. 7-10),
/// both in map. The text calls δ = λ v a variance, but eq. 8-10 square it: it is the standard
/// deviation. Velocities are taken per scan: the motion from `last` to `initial_guess`. The map's x
/// and y have nothing to tell them apart, so λ1 = λ2.
CandidateSpread motionSpread(const Pose2& last, const Pose2& initial_guess,
                             const ProgressiveConfig& config);

/// Mean over the points of the probability of the cell that each hits on `level`, where that is
/// occupied, else 0 (paper 002 eq. 21, whose sum is divided by N); 0 without points.
double votingLikelihood(const OccupancyGrid& grid, int level, const Points& points,
                        const Pose2& map_T_base);

/// What one level says of the pose.
struct LevelEstimate {
  Pose2 pose;  ///< of the best candidate (eq. 19)
  Pose2 mean;  ///< of the candidates, weighted by their likelihood: finer than their distance
  double vote = 0.0;  ///< of the best candidate (eq. 21)
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of the weighted candidates: the sampled posterior of eq. 4
};

/// The candidate around `center` with the largest P(z|x, M) P(x|x*) (paper 002 eq. 19). Only the
/// order of the votes is given by eq. 21; read as a likelihood, log P(z|x, M) = `beams` × vote.
/// Where nothing votes that is the center.
LevelEstimate bestCandidate(const OccupancyGrid& grid, int level, const Points& points,
                            const Pose2& center, const CandidateSpread& spread,
                            const StandardCandidates& candidates, double beams);

/// The estimates of the levels (paper 002 fig. 4), coarse to fine.
struct Refinement {
  std::array<Pose2, kMatchStages> poses;  ///< x(i); after a stop all the one that was kept
  std::array<CandidateSpread, kMatchStages> spreads;
  std::array<double, kMatchStages> corrections_m{};  ///< |x(i) - x*(i)|, the rejected one as well
  int levels = 0;                                    ///< whose estimate was kept
  bool stopped = false;  ///< a finer correction exceeded the coarser one
  LevelEstimate finest;  ///< of those that were kept
};

/// Refines a pose over the levels of a grid. Stateless but for the candidates, which are drawn
/// once.
class ProgressiveRefiner {
 public:
  explicit ProgressiveRefiner(const ProgressiveConfig& config);

  /// Every level starts at the estimate of the coarser one, with a candidate space that is smaller
  /// by `shrink`. Stops, and keeps the coarser estimate, where a level corrects by more than the
  /// one before. The paper leaves |·| of a pose open: here the displacement that the correction
  /// gives to a point at the mean range of the scan. To the letter the rule stops every second scan
  /// of a real recording, where the prediction was good by chance: see `slack_cells`.
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
